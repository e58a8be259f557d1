"""The control socket: permissions, protocol errors, and how a run is found."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import stat
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import psutil
import pytest

from launcher.control.client import Connection, ControlError, RefusedError
from launcher.control.control_server import Server
from launcher.posix.reactor import Reactor
from tests.support.benches import ControlBench
from tests.support.controlled_run import TIMEOUT_S, ControlledRun, state_of
from tests.support.raw_client import RawClient, error_of
from tests.support.verbs import launcher
from tests.support.waiting import wait_until

CAT = 'sh("exec cat", name="cat")'
NOBODY = 65534


# ---- who gets in


def test_the_socket_and_its_folder_are_for_their_user_alone(run: ControlledRun):
    assert stat.S_IMODE(run.socket.stat().st_mode) == 0o600
    assert stat.S_IMODE(run.socket.parent.stat().st_mode) == 0o700
    assert run.socket.stat().st_uid == os.getuid()


AS_SOMEBODY_ELSE = """
import contextlib, os, socket, sys
os.setgid(int(sys.argv[2])); os.setuid(int(sys.argv[2]))
s = socket.socket(socket.AF_UNIX)
try:
    s.connect(sys.argv[1])
except PermissionError:
    sys.exit("kept out")
with contextlib.suppress(BrokenPipeError):
    s.sendall(b'{"verb": "quit"}\\n')
print(s.makefile("rb").readline().decode())
"""


def ask_as_nobody(path: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", AS_SOMEBODY_ELSE, str(path), str(NOBODY)],
        capture_output=True,
        text=True,
        check=False,
        timeout=TIMEOUT_S,
    )


def check_that_nobody_is_refused(run: ControlledRun) -> None:
    """Only root can become another user."""
    path = run.socket
    assert "kept out" in ask_as_nobody(path).stderr
    for folder in (path.parent, path.parent.parent):
        folder.chmod(0o755)
    path.chmod(0o666)
    assert error_of(json.loads(ask_as_nobody(path).stdout)) == "refused"
    assert run.row("cat")["state"] == "RUNNING"
    assert f"refused a connection of user {NOBODY}" in run.screen


def check_that_we_are_refused_by_somebody_else(path: Path) -> None:
    """Others can only be somebody else for a server that belongs to another."""
    said: list[str] = []
    with Reactor() as reactor:
        server = Server(
            reactor,
            lambda: path,
            hello=dict,
            serve=lambda request, exchange: exchange.reply({}),
            warn=said.append,
            owner=os.getuid() + 1,
        )
        thread = threading.Thread(target=reactor.run)
        thread.start()
        with pytest.raises(RefusedError, match="belongs to another user"):
            Connection(path)
        reactor.stop()
        connect_and_go(path)
        thread.join()
        server.close()
    assert said[0].startswith(f"refused a connection of user {os.getuid()} ")


def connect_and_go(path: Path) -> None:
    """Wake a reactor up."""
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(os.fspath(path))


def test_another_user_is_refused(run: ControlledRun):
    if os.getuid() == 0:
        check_that_nobody_is_refused(run)
    else:
        check_that_we_are_refused_by_somebody_else(run.socket.with_name("other.sock"))


def test_a_folder_that_is_open_to_others_is_not_used(control_bench: ControlBench):
    folder = control_bench.runtime / "ros-launcher"
    folder.mkdir(mode=0o755)
    folder.chmod(0o755)
    spare = control_bench.runtime / "spare"
    spare.mkdir()
    control_bench.env["TMPDIR"] = str(spare)
    with control_bench.launch(CAT) as run:
        wanted = spare / f"ros-launcher-{os.getuid()}"
        wait_until(lambda: list(wanted.glob("*.sock")), "a socket in the other folder")
        assert not list(folder.iterdir())
        assert run.shell("ps").returncode == 0


OBSTACLES = ["file", "loose", "link", "long", *(["foreign"] if os.getuid() == 0 else [])]


def put_in_the_way(obstacle: str, root: Path) -> None:
    place = root / f"ros-launcher-{os.getuid()}"
    if obstacle == "file":
        place.write_text("")
    elif obstacle == "loose":
        place.mkdir()
        place.chmod(0o770)
    elif obstacle == "link":
        (root / "mine").mkdir(mode=0o700)
        place.symlink_to(root / "mine")
    elif obstacle == "foreign":
        place.mkdir(mode=0o700)
        os.chown(place, NOBODY, NOBODY)


@pytest.mark.thorough
@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_a_run_without_a_place_for_its_socket_says_so_once_and_goes_on(
    control_bench: ControlBench, obstacle: str
):
    root = control_bench.runtime / ("x" * 100 if obstacle == "long" else "tmp")
    root.mkdir()
    put_in_the_way(obstacle, root)
    control_bench.env["TMPDIR"] = str(root)
    control_bench.runtime = control_bench.runtime / "nowhere"
    with control_bench.launch(CAT) as run:
        run.wait_for("cannot open the control socket")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0
        assert run.screen.count("cannot open the control socket") == 1
        assert "process has finished cleanly" in run.screen or "was stopped" in run.screen
    assert not list(root.rglob("*.sock"))


def test_a_run_without_control_has_no_socket(control_bench: ControlBench):
    control_bench.env["XDG_RUNTIME_DIR"] = str(control_bench.runtime)
    done = control_bench.run('sh("sleep 0.5")', "--no-control")
    assert done.returncode == 0
    assert not list(control_bench.runtime.iterdir())


# ---- what is said


def test_the_first_line_says_which_run_it_is(control_bench: ControlBench):
    control_bench.env["ROS_DOMAIN_ID"] = "42"
    with control_bench.launch(CAT) as run, RawClient(run.socket) as client:
        assert client.hello is not None
        assert client.hello["protocol"] == 2
        told = client.hello["run"]
        assert told["id"] == run.socket.stem
        assert told["pid"] == run.process.pid
        assert told["domain_id"] == 42
        assert told["processes"] == ["cat-1"]
        assert told["target"] == str(control_bench.folder / "bench.launch.py")


def test_a_client_of_another_version_gets_the_supported_version(run: ControlledRun):
    with RawClient(run.socket) as client:
        client.send(b'{"protocol": 1, "id": "a", "verb": "ps"}\n')
        answer = client.read()
        assert error_of(answer) == "version"
        assert answer["id"] == "a"
        assert ": this run uses 2" in answer["error"]["message"]
        client.send(b'{"protocol": 2, "id": "b", "verb": "ps"}\n')
        assert client.read()["ok"]  # it may go on in ours


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("line", "code"),
    [
        (b"hello", "bad-request"),
        (b"\xff\xfe", "bad-request"),
        (b"[]", "bad-request"),
        (b'{"verb": 7}', "bad-request"),
        (b'{"verb": "stop", "names": "cat"}', "bad-request"),
        (b'{"verb": "stop", "names": []}', "bad-request"),
        (b'{"verb": "ps", "id": NaN}', "bad-request"),
        (b'{"verb": "ps", "id": 1e999}', "bad-request"),
        (b'{"verb": "ps", "id": ' + b"1" * 5000 + b"}", "bad-request"),
        (b"[" * 60_000, "bad-request"),
        (b'{"verb": "ps", "id": [1]}', "bad-request"),
        (b'{"verb": "ps", "options": {"x": 1}}', "bad-option"),
        (b'{"verb": "kill", "names": ["cat"], "options": {"signal": "SIGNAL"}}', "bad-option"),
        (b'{"verb": "logs", "options": {"lines": -1}}', "bad-option"),
        (b'{"verb": "logs", "options": {"lines": true}}', "bad-option"),
        (b'{"verb": "level", "options": {"level": "LOUD"}}', "bad-option"),
        (b'{"verb": "dance"}', "unknown-verb"),
        (b'{"verb": "__init__"}', "unknown-verb"),
        (b'{"verb": "stop", "names": ["\\ud800"]}', "unknown-name"),
    ],
)
def test_an_invalid_request_is_answered_and_the_connection_stays_open(
    run: ControlledRun, line: bytes, code: str
):
    with RawClient(run.socket) as client:
        client.send(line + b"\n\n" + b'{"verb": "ps"}\n')
        assert error_of(client.read()) == code
        assert client.read()["ok"]


# ---- which run


def test_the_socket_of_a_killed_launcher_is_removed_with_a_message(run: ControlledRun):
    path = run.socket
    run.process.send_signal(signal.SIGKILL)
    run.process.wait()
    assert path.exists()
    done = run.shell("ps")
    assert done.returncode == 1
    assert f"removed the socket of a run that was killed: {path.stem}" in done.stderr
    assert "no active run" in done.stderr
    assert not path.exists()


def test_of_two_runs_one_has_to_be_picked(control_bench: ControlBench):
    one = control_bench.launch(CAT)
    ids = [one.socket.stem]  # it listens, so it has read the launch file, which changes now
    two = control_bench.launch('sh("exec cat", name="tac")')
    ids.append(two.socket.stem)
    unclear = one.shell("ps")
    assert unclear.returncode == 1
    assert all(run_id in unclear.stderr for run_id in ids)
    for run, name in ((one, "cat-1"), (two, "tac-1")):
        for which in (run.socket.stem, str(run.process.pid), run.socket.stem[:-3]):
            done = one.shell("ps", "--json", "--run", which)
            assert json.loads(done.stdout)["processes"][0]["name"] == name
    listed = json.loads(one.shell("runs", "--json").stdout)["runs"]
    assert [entry["id"] for entry in listed] == ids
    assert one.shell("ps", "--run", "bench").returncode == 1  # both are from that file
    assert one.shell("quit", "--run", ids[1]).returncode == 0
    assert two.exit_code() == 0
    assert json.loads(one.shell("ps", "--json").stdout)["processes"][0]["name"] == "cat-1"


@pytest.mark.thorough
def test_a_suspended_run_is_reported_as_not_answering(run: ControlledRun):
    path = run.socket
    run.process.send_signal(signal.SIGSTOP)
    wait_until(lambda: state_of(run.process.pid) == psutil.STATUS_STOPPED, "it stands still")
    with pytest.raises(ControlError, match="does not answer"):
        Connection(path, timeout_s=0.2)
    for words in (("ps",), ("quit",), ("ps", "--run", str(run.process.pid))):
        done = run.shell(*words)
        assert done.returncode == 1
        assert f"(pid {run.process.pid}) does not answer (suspended" in done.stderr
        assert f"kill -CONT {run.process.pid}" in done.stderr
    assert "does not answer (suspended: state T)" in run.shell("runs").stdout
    (listed,) = json.loads(run.shell("runs", "--json").stdout)["runs"]
    assert listed["id"] == path.stem and "state T" in listed["problem"]
    run.process.send_signal(signal.SIGCONT)
    assert run.row("cat")["state"] == "RUNNING"


@pytest.mark.thorough
def test_verbs_that_change_a_run_do_not_pick_one_of_another_folder(run: ControlledRun):
    assert run.socket
    with tempfile.TemporaryDirectory(prefix="session-") as session:
        # For this shell, the run is in the folder that is looked at second.
        beside = Path(run.env["TMPDIR"]) / f"ros-launcher-{os.getuid()}"
        path = run.socket
        beside.mkdir(mode=0o700)
        os.link(path, beside / path.name)  # its own is left: it would be made anew
        run.env["XDG_RUNTIME_DIR"] = session
        looked = launcher(run.env, "ps", "--json")
        assert json.loads(looked.out)["processes"][0]["name"] == "cat-1"
        refused = launcher(run.env, "quit")
        assert refused.code == 1 and "--run" in refused.err
        assert f"no active run in {session}" in refused.err
        assert launcher(run.env, "quit", "--run", str(run.process.pid)).code == 0
        assert run.exit_code() == 0


@pytest.mark.thorough
def test_a_removed_socket_is_created_again_and_reported_once(run: ControlledRun):
    for _ in range(2):
        path = run.socket
        # In one step: it is made again as soon as it is missed.
        shutil.rmtree(path.parent.rename(path.parent.with_name("gone")))
        wait_until(path.exists, "the socket made again")
        assert run.row("cat")["state"] == "RUNNING"
    assert run.screen.count("was removed and is created again") == 1
    run.ask_text("quit")
    assert run.exit_code() == 0
    assert not path.exists()
