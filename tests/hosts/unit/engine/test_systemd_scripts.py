"""Scripts for a host with systemd in a real shell; what needs systemd itself fails there."""

from __future__ import annotations

import json
import os
import random
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest

from launcher.base.model.record import replace
from launcher.hosts.engine.link import LinkContext, LinkListener
from launcher.hosts.engine.systemd import journal
from launcher.hosts.engine.systemd.host_facts import HostFacts, hello, read_facts
from launcher.hosts.engine.systemd.samples import Samples
from launcher.hosts.engine.systemd.scripts import Scripts
from launcher.hosts.engine.systemd.shell import Answers, ScriptRequest, ScriptResult
from launcher.hosts.engine.systemd.systemd_link import SystemdLink
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.file.order import Order
from launcher.hosts.file.references import SentFile
from launcher.hosts.ssh import posix_shell, python_script
from launcher.hosts.sync import release_python, sync_session
from launcher.posix.reactor import Reactor


def facts(folder: Path, **fields: object) -> HostFacts:
    known = {
        "uid": 0,
        "user": "me",
        "home": str(folder),
        "runtime": str(folder),
        "version": 252,
        "state": "running",
        "lingers": True,
        "boot_id": "b",
        "uptime_s": 1.0,
        "cursor": None,
        "has_launcher": True,
        "python": sys.executable,
    }
    return HostFacts(**{**known, **fields})  # type: ignore[arg-type]


def test_a_python_that_is_not_there_is_told_apart_from_one_without_the_launcher(tmp_path: Path):
    absent = Host(name="bot1", address="10.0.0.2", python="/opt/not/there/bin/python")
    answers = [
        shell(hello(host), tmp_path).stdout.decode()
        for host in (absent, replace(absent, python="false"))
    ]

    assert [answer.splitlines()[-1] for answer in answers] == ["launcher no python", "launcher "]
    assert read_facts(answers[0]).lacks_python
    assert not read_facts(answers[1]).lacks_python


def shell(script: str, folder: Path, **options: object) -> subprocess.CompletedProcess[bytes]:
    env = {"PATH": os.environ["PATH"], "HOME": str(folder)}
    words = ["/bin/sh", "-c", script] if len(script) < 100_000 else ["/bin/sh"]
    return subprocess.run(words, cwd=folder, env=env, capture_output=True, **options)  # type: ignore[call-overload,no-any-return]


def ran(scripts: Scripts, order: Order, folder: Path) -> str:
    """What a process writes that is started with its script, as its unit does."""
    shell(scripts.prepare(), folder)
    assert shell(scripts.files(1, order), folder).returncode == 0
    done = shell(f"exec /bin/sh {scripts.folder}/1/start", folder)
    assert done.returncode == 0, done.stderr
    return done.stdout.decode()


def test_variables_whose_names_no_shell_takes_arrive(tmp_path: Path):
    values = {"A.B": "it's\n$(id)", "x-y": "gr\udcffün", "PLAIN": "\x01"}
    words = ((sys.executable,), ("-c",), ("import json, os; print(json.dumps(dict(os.environ)))",))
    order = Order(name="a-1", label="a", words=words, environment=values, merge=True)

    scripts = Scripts("k3", Host("bot1", "b"), facts(tmp_path))
    found = json.loads(ran(scripts, order, tmp_path))

    assert {name: found.get(name) for name in values} == values


def test_the_shell_that_announces_a_process_does_not_call_itself_so(tmp_path: Path):
    scripts = Scripts("k3", Host("bot1", "b"), facts(tmp_path))
    order = Order(name="a-1", label="a", words=(("/opt/nope",),), environment={})
    assert shell(scripts.files(7, order), tmp_path).returncode == 0
    words = shlex.split(Path(scripts.folder, "7/start").read_text().splitlines()[-1])
    done = subprocess.run(words[words.index("/bin/sh") :], capture_output=True, check=False)

    told = f"{journal.announcement(7)}\n".encode()
    assert done.stdout == told
    assert done.stderr.startswith(told + b"sh: ")


@pytest.mark.parametrize("uid", [0, 1000])
def test_output_of_a_user_begins_with_whose_it_is(tmp_path: Path, uid: int):
    scripts = Scripts("k3", Host("bot1", "b"), facts(tmp_path, uid=uid))
    order = Order(name="a-1", label="a", words=(("echo",),), environment={}, merge=True)

    told = f"{journal.announcement(1)}\n" if uid else ""
    assert ran(scripts, order, tmp_path) == f"{told}\n"


def test_launchers_of_a_run_have_marks_of_their_own(tmp_path: Path):
    def asked(reactor: Reactor) -> str:
        listener = cast("LinkListener", None)
        link = SystemdLink(LinkContext(Host("bot1", "b"), listener, reactor, "1-k3", {}))
        link._know(facts(tmp_path))
        link._when_marked(lambda: None)
        return link._sessions._queue[-1].script

    with Reactor() as reactor:
        assert asked(reactor) != asked(reactor)


class Shell:
    """A channel to a shell on the host."""

    def __init__(self) -> None:
        self.written = b""

    def write(self, data: bytes) -> None:
        self.written += data


def test_the_watch_is_told_of_the_operator_before_all_lines_have_been_caught_up_with(
    tmp_path: Path,
):
    known = facts(tmp_path)
    with Reactor() as reactor:
        listener = cast("LinkListener", None)
        link = SystemdLink(LinkContext(Host("bot1", "b"), listener, reactor, "1-k3", {}))
        link._know(known)
        link._has_watch = True
        link._send_beat()  # there is no shell
        link._sessions._shell = there = cast("Any", Shell())

        assert link.met_again(known)
        assert there.written.count(b"/k3/beat") == 1
        link._send_beat()
        assert there.written.count(b"/k3/beat") == 2


@pytest.mark.parametrize(
    ("stop_after_s", "now", "expires"),
    [
        (1.0, "12.05", False),
        (1.0, "12.20", True),
        (2.0, "13.10", False),
        (2.5, "13.60", False),
        (2.5, "13.70", True),
    ],
)
def test_the_watch_expires_after_its_time(
    tmp_path: Path, stop_after_s: float, now: str, expires: bool
):
    """The last beat was at 11.20; it may be a whole second old although the operator is there."""
    known = facts(tmp_path)
    scripts = Scripts("k3", Host("bot1", "b"), known)
    uptime, tools = tmp_path / "uptime", tmp_path / "bin"
    tools.mkdir()
    for name, text in {
        "sleep": f"[ ! -e {tmp_path}/looked ] && touch {tmp_path}/looked",
        "systemctl": "echo stopped",
        "systemd-cat": "true",
        "systemd-run": "true",
    }.items():
        (tools / name).write_text(f"#!/bin/sh\n{text}\n")
        (tools / name).chmod(0o755)

    def told(script: str, up: str) -> str:
        uptime.write_text(f"{up} 99.00\n")
        env = {"PATH": f"{tools}:{os.environ['PATH']}"}
        words = ["sh", "-c", script.replace("/proc/uptime", str(uptime))]
        return subprocess.run(words, env=env, capture_output=True, text=True, check=False).stdout

    shell(scripts.prepare(), tmp_path)
    told(scripts.watch(stop_after_s), "11.20")
    watch = Path(scripts.folder, "watch").read_text()

    assert (told(watch, now) == "stopped\n") == expires


@pytest.mark.parametrize("missing", ["getconf", "grep"])
def test_a_sample_needs_no_program_of_the_host(tmp_path: Path, missing: str):
    for name in {"getconf", "grep"} - {missing}:
        (tmp_path / name).symlink_to(str(shutil.which(name)))
    pid, samples = os.getpid(), Samples()
    answered: list[ScriptResult] = []
    answers = Answers(lambda beat: None)
    script = answers.framed(ScriptRequest(samples.script([pid], 1.0), answered.append))

    words, env = [str(shutil.which("sh"))], {"PATH": str(tmp_path)}
    answers.feed(
        subprocess.run(words, input=script, env=env, capture_output=True, check=True).stdout
    )

    (found,) = samples.read(answered[0].text, {3: pid}, 1.0).values()
    assert found["rss_bytes"] > 1_000_000
    assert (found["uss_bytes"] is None) == (missing == "grep")


@pytest.mark.parametrize(
    ("table", "root"),
    [
        ("0::UNIT", "."),
        ("2:cpu:/\n1:name=systemd:UNIT\n0::UNIT", "systemd"),
        ("2:cpu:/\n1:name=systemd:UNIT\n0::/", "systemd"),  # systemd does not use version 2
        ("1:name=systemd:/\n0::UNIT", "unified"),
        ("1:name=systemd:/user.slice/session-1.scope\n0::/", "systemd"),
    ],
)
def test_all_processes_of_a_unit_are_found(tmp_path: Path, table: str, root: str):
    unit = r"/launcher_k3.slice/launcher-k3-a\x20b:c-1.service"
    groups = tmp_path / "groups"
    for folder in (groups / root / unit[1:], *(tmp_path / pid for pid in "78")):
        folder.mkdir(parents=True)
    (groups / root / unit[1:] / "cgroup.procs").write_text("8\n7\n9\n")
    (tmp_path / "uptime").write_text("5.00 1.00\n")
    (tmp_path / "7/cgroup").write_text(f"{table.replace('UNIT', unit)}\n")
    for pid in "78":
        (tmp_path / pid / "stat").write_text(f"{pid} (a) b) S {'1 ' * 40}\n")

    script = Samples().script([7], 1.0).replace("/proc/", f"{tmp_path}/")
    found = shell(script.replace("/sys/fs/cgroup", str(groups)), tmp_path).stdout.decode()

    lines = [line.split()[:3] for line in found.splitlines() if line.startswith("process")]
    members = ["7", "8"] if unit in (tmp_path / "7/cgroup").read_text() else ["7"]
    assert lines == [["process", "7", member] for member in members]


# ---- nothing that a file or an order says is run by a shell

PIECES = ("$(>F)", "`>F`", "; >F;", "\n", "'", '"', "\\", "${X}", "&", "|>F", "E\n")
TOOLS = "base64 cat chmod dd head id mkdir mkfifo mv rm rmdir sh sleep tail true"


def nasty(chance: random.Random) -> str:
    return "".join(chance.choice(PIECES) for _ in range(chance.randrange(1, 5))) + "x"


def name_of(chance: random.Random) -> str:
    return nasty(chance).replace("/", "_")


@pytest.fixture
def tools(tmp_path: Path) -> Path:
    """The programs of a host without systemd, so that nothing happens on this one."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for name in TOOLS.split():
        (folder / name).symlink_to(str(shutil.which(name)))
    return folder


def order_of(chance: random.Random) -> Order:
    values = [nasty(chance) for _ in range(8)]
    return Order(
        name=values[0],
        label=values[1],
        words=(("true",), (values[2],), (SentFile("file"),)),
        environment={"PLAIN": values[3], "CONTROL": f"{values[4]}\x01", values[5]: values[6]},
        unset=(values[7], "UNSET"),
        cwd=values[0],
        files={"file": values[1].encode()},
        merge=chance.random() < 0.5,
        shell=chance.random() < 0.2,
    )


def scripts_of(chance: random.Random, home: Path) -> Iterator[str]:
    host = Host(
        name="bot1",
        address="b",
        python=name_of(chance),
        setup=(name_of(chance),),
        workspace=name_of(chance),
        ssh={},
    )
    (home / host.setup[0]).touch()  # a shell ends where one is missing
    known = facts(home, user=nasty(chance), runtime=f"{home}/{name_of(chance)}")
    order, scripts = order_of(chance), Scripts("k3abcd", host, known)
    yield scripts.prepare()
    yield scripts.files(1, order)
    yield f". {shlex.quote(f'{scripts.folder}/1/environment')}"
    yield f"exec sh {shlex.quote(f'{scripts.folder}/1/start')}"
    yield scripts.start(1, order, "token")
    yield scripts.stop(order.name)
    yield scripts.signal(order.name, 10)
    yield scripts.hold(1)
    yield scripts.release(1)
    yield scripts.write_stdin(1, nasty(chance).encode())
    yield scripts.show([order.name])
    yield scripts.mark("m1")
    yield scripts.manifest({"title": nasty(chance)})
    yield scripts.watch(1.0)
    yield scripts.finish([order.name], nasty(chance), at_once=True)
    yield hello(host)
    yield python_script(host, [nasty(chance)])
    yield sync_session.script(host)
    yield (release_python.of_host("a/b", f"/{nasty(chance)}").content or b"").decode()
    yield (release_python.of_environment(nasty(chance)).content or b"").decode()


@pytest.mark.parametrize("seed", range(8))
def test_no_value_is_run_by_a_shell(tmp_path: Path, tools: Path, seed: int):
    chance = random.Random(seed)
    home = tmp_path / "home"
    home.mkdir()
    env = {"PATH": str(tools), "HOME": str(home)}
    for script in scripts_of(chance, home):
        for words in (["sh", "-c", script], ["sh", "-c", posix_shell(script)]):
            options = {"input": b"", "capture_output": True, "timeout": 60}
            subprocess.run(words, cwd=home, env=env, check=False, **options)  # type: ignore[call-overload]
            assert [path for path in tmp_path.rglob("F") if path.name == "F"] == [], script
