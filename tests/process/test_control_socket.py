"""The socket of a run: who gets in, and what clients of every kind can do to it: nothing."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import stat
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from launcher.control.client import ControlError, RefusedError, connect
from launcher.control.protocol import REQUEST_LIMIT
from launcher.control.server import Server
from launcher.engine.reactor import Reactor
from tests.process.conftest import SteeringBench
from tests.support.steered import PATIENCE_S, Steered
from tests.support.waiting import wait_until

CAT = 'sh("exec cat", name="cat")'
NOBODY = 65534


class Raw:
    """A client that says what it likes."""

    def __init__(self, path: Path) -> None:
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(PATIENCE_S)
        self.socket.connect(os.fspath(path))
        self._lines = self.socket.makefile("rb")
        self.hello = self.read()

    def __enter__(self) -> Raw:
        return self

    def __exit__(self, *exc: object) -> None:
        self._lines.close()
        self.socket.close()

    def say(self, data: bytes) -> None:
        self.socket.sendall(data)

    def read(self) -> dict | None:
        """The next line; None when the connection is over."""
        line = self._lines.readline()
        return json.loads(line) if line else None


@pytest.fixture
def run(steering: SteeringBench) -> Iterator[Steered]:
    with steering.steer(CAT) as one:
        yield one


def error_of(answer: dict | None) -> str:
    assert answer is not None
    assert not answer["ok"]
    return answer["error"]["code"]


# ---- who gets in


def test_the_socket_and_its_folder_are_for_their_user_alone(run: Steered):
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
        timeout=PATIENCE_S,
    )


def check_that_nobody_is_refused(run: Steered) -> None:
    """Only root can become somebody else."""
    path = run.socket
    assert "kept out" in ask_as_nobody(path).stderr
    for folder in (path.parent, path.parent.parent):
        folder.chmod(0o755)
    path.chmod(0o666)
    assert error_of(json.loads(ask_as_nobody(path).stdout)) == "refused"
    assert run.row("cat")["state"] == "RUNNING"
    assert f"refused to be steered by user {NOBODY}" in run.screen


def check_that_we_are_refused_by_somebody_else(path: Path) -> None:
    """Others can only be somebody else for a server that belongs to another."""
    said: list[str] = []
    with Reactor() as reactor:
        server = Server(
            reactor,
            path,
            hello=dict,
            serve=lambda request, exchange: exchange.reply({}),
            warn=said.append,
            owner=os.getuid() + 1,
        )
        thread = threading.Thread(target=reactor.run)
        thread.start()
        with pytest.raises(RefusedError, match="belongs to somebody else"):
            connect(path)
        reactor.stop()
        connect_and_go(path)
        thread.join()
        server.close()
    assert said[0].startswith(f"refused to be steered by user {os.getuid()} ")


def connect_and_go(path: Path) -> None:
    """Wake a reactor up."""
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(os.fspath(path))


def test_another_user_is_refused(run: Steered):
    if os.getuid() == 0:
        check_that_nobody_is_refused(run)
    else:
        check_that_we_are_refused_by_somebody_else(run.socket.with_name("other.sock"))


def test_a_folder_that_is_open_to_others_is_not_used(steering: SteeringBench):
    folder = steering.runtime / "ros-launcher"
    folder.mkdir(mode=0o755)
    folder.chmod(0o755)
    spare = steering.runtime / "spare"
    spare.mkdir()
    steering.env["TMPDIR"] = str(spare)
    with steering.steer(CAT) as run:
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


@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_a_run_without_a_place_for_its_socket_says_so_once_and_goes_on(
    steering: SteeringBench, obstacle: str
):
    root = steering.runtime / ("x" * 100 if obstacle == "long" else "tmp")
    root.mkdir()
    put_in_the_way(obstacle, root)
    steering.env["TMPDIR"] = str(root)
    steering.runtime = steering.runtime / "nowhere"
    with steering.steer(CAT) as run:
        run.wait_for("this run cannot be steered from elsewhere")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0
        assert run.screen.count("cannot be steered") == 1
        assert "process has finished cleanly" in run.screen or "was stopped" in run.screen
    assert not list(root.rglob("*.sock"))


def test_a_run_without_control_has_no_socket(steering: SteeringBench):
    steering.env["XDG_RUNTIME_DIR"] = str(steering.runtime)
    done = steering.run('sh("sleep 0.5")', "--no-control")
    assert done.returncode == 0
    assert not list(steering.runtime.iterdir())


# ---- what is said


def test_the_first_line_says_which_run_it_is(steering: SteeringBench):
    steering.env["ROS_DOMAIN_ID"] = "42"
    with steering.steer(CAT) as run, Raw(run.socket) as client:
        assert client.hello is not None
        assert client.hello["protocol"] == 1
        told = client.hello["run"]
        assert told["id"] == run.socket.stem
        assert told["pid"] == run.process.pid
        assert told["domain_id"] == 42
        assert told["processes"] == ["cat-1"]
        assert told["target"] == str(steering.folder / "bench.launch.py")


def test_another_version_is_told_which_one_is_spoken(run: Steered):
    with Raw(run.socket) as client:
        client.say(b'{"protocol": 2, "id": "a", "verb": "ps"}\n')
        answer = client.read()
        assert error_of(answer) == "version"
        assert answer["id"] == "a"
        assert "speaks protocol 1" in answer["error"]["message"]
        client.say(b'{"protocol": 1, "id": "b", "verb": "ps"}\n')
        assert client.read()["ok"]  # it may go on in ours


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
def test_what_is_no_request_is_answered_and_the_connection_goes_on(
    run: Steered, line: bytes, code: str
):
    with Raw(run.socket) as client:
        client.say(line + b"\n\n" + b'{"verb": "ps"}\n')
        assert error_of(client.read()) == code
        assert client.read()["ok"]


# ---- who does harm

DOCUMENTS = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=9), inner),
    max_leaves=20,
)
VERBS = st.sampled_from(["ps", "top", "logs", "events", "info", "plan", "help", "level", "grep"])
REQUESTS = st.fixed_dictionaries(
    {"verb": VERBS | st.text(max_size=9)},
    optional={
        "protocol": st.integers(0, 2) | DOCUMENTS,
        "id": DOCUMENTS,
        "names": st.lists(st.sampled_from(["cat", "*", "["]) | st.text(), max_size=4) | DOCUMENTS,
        "options": st.dictionaries(
            st.sampled_from(["follow", "lines", "signal", "level", "pattern", "period_s"]),
            DOCUMENTS,
        )
        | DOCUMENTS,
    },
)


@given(
    st.lists(
        st.binary(max_size=200)
        | st.builds(lambda x: json.dumps(x).encode() + b"\n", REQUESTS | DOCUMENTS),
        max_size=6,
    )
)
@example([b"[" * 60_000 + b"\n"])
@example([b'{"a":' * 10_000 + b"\n"])
@example([b'{"verb": "ps", "id": ' + b"9" * 60_000 + b"}\n"])
@example([b'{"verb": "grep", "options": {"pattern": "' + b"(" * 20_000 + b'"}}\n'])
@example([b"\n" * 60_000])
@example([b'{"verb":"ps"}\n' * 4000])
@settings(
    max_examples=150,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_no_words_harm_a_run(run: Steered, words: list[bytes]):
    with contextlib.suppress(OSError), Raw(run.socket) as client:
        for data in words:
            client.say(data)
    assert run.row("cat")["state"] == "RUNNING"
    assert run.process.poll() is None
    assert "Traceback" not in run.screen


def test_a_request_may_come_byte_by_byte_while_others_are_served(run: Steered):
    with Raw(run.socket) as slow, Raw(run.socket) as other:
        for byte in b'{"id": 1, "verb": "ps"}\n':
            other.say(b'{"verb": "ps"}\n')
            assert other.read()["ok"]
            slow.say(bytes([byte]))
        assert slow.read()["id"] == 1


def test_a_line_without_an_end_is_refused_at_its_limit(run: Steered):
    with Raw(run.socket) as client:
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            for _ in range(1000):
                client.say(b"x" * REQUEST_LIMIT)
        answer = client.read()
        assert error_of(answer) == "bad-request"
        assert "at most 65536 bytes" in answer["error"]["message"]
        with contextlib.suppress(ConnectionResetError):
            assert client.read() is None
    assert run.row("cat")["state"] == "RUNNING"


def test_a_client_that_has_said_all_gets_its_answers_and_is_forgotten_when_it_goes(run: Steered):
    run.ask("ps")
    before = run.open_files()
    with Raw(run.socket) as client:
        client.say(b'{"id": 1, "verb": "ps"}\n{"id": 2, "verb": "restart", "names": ["cat"]}\n')
        client.socket.shutdown(socket.SHUT_WR)
        assert [client.read()["id"], client.read()["id"]] == [1, 2]
        assert client.read() is None
    with Raw(run.socket) as client:
        client.say(b'{"id": 3, "verb": "events", "options": {"follow": true}}\n')
        client.socket.shutdown(socket.SHUT_WR)
        assert client.read()["item"]["event"] == "started"
        run.tell("restart", "cat")
        while client.read()["item"]["event"] != "ended":
            pass  # it is told what happens although it has nothing more to say
    wait_until(lambda: run.open_files() <= before, "the connection given back")


def test_a_hundred_clients_are_served_while_the_output_flows(steering: SteeringBench):
    lines = 20_000
    writer = f'sh("read go; seq {lines}; echo over", name="writer")'
    with steering.steer(f"{writer}, {CAT}") as run:
        path = run.socket
        answered = []

        def client(number: int) -> None:
            with connect(path, patience_s=PATIENCE_S) as connection:
                for verb in ("ps", "logs", "info", "events", "ps"):
                    names = ["writer"] if verb in ("logs", "info") else []
                    answer = connection.ask(verb, names, patience_s=60)
                    assert answer.result
                answered.append(number)

        clients = [threading.Thread(target=client, args=(number,)) for number in range(100)]
        run.tell("send", "writer", text="go")
        for thread in clients:
            thread.start()
        for thread in clients:
            thread.join()
        run.wait_for("[writer-1] over\n")
        assert len(answered) == 100
        shown = [line for line in run.screen.splitlines() if line.startswith("[writer-1] ")]
        assert shown == [*(f"[writer-1] {n}" for n in range(1, lines + 1)), "[writer-1] over"]


def test_a_follower_that_does_not_read_loses_lines_and_nobody_else_does(steering: SteeringBench):
    lines = 50_000
    writer = f'sh("read go; seq {lines}; echo over", name="writer")'
    with steering.steer(f"{writer}, {CAT}") as run, run.connect() as lazy:
        request = lazy.send("logs", ["writer"], follow=True, lines=0)
        # Answered in turn, so after this the other one is served.
        lazy.ask("ps")
        run.tell("send", "writer", text="go")
        run.wait_for("[writer-1] over\n")
        shown = [line for line in run.screen.splitlines() if line.startswith("[writer-1] ")]
        assert shown[:-1] == [f"[writer-1] {n}" for n in range(1, lines + 1)]
        got = dropped = 0
        while got + dropped < lines + 1:
            answer = lazy.read(PATIENCE_S)
            assert answer["id"] == request
            if "dropped" in answer["item"]:
                dropped += answer["item"]["dropped"]
            else:
                got += 1
        assert dropped > 0
        assert got + dropped == lines + 1


def test_a_client_that_asks_and_never_reads_is_not_served_for_ever(run: Steered):
    with Raw(run.socket) as greedy:
        greedy.socket.settimeout(0.5)
        with contextlib.suppress(TimeoutError):
            for _ in range(100_000):
                greedy.say(b'{"verb": "help"}\n')
        memory = Path(f"/proc/{run.process.pid}/status").read_text()
        resident = next(line for line in memory.splitlines() if line.startswith("VmRSS"))
        assert int(resident.split()[1]) < 200_000  # kB: what waits for it is bounded
        assert run.row("cat")["state"] == "RUNNING"


def test_clients_take_no_descriptors_that_processes_need(steering: SteeringBench):
    with steering.steer(CAT, files=80) as run:
        path = run.socket
        clients = []
        for _ in range(100):
            client = socket.socket(socket.AF_UNIX)
            client.connect(os.fspath(path))
            clients.append(client)
        run.wait_for("a client has to wait: Too many open files")
        first = clients[0].makefile("rwb")
        first.readline()
        first.write(b'{"verb": "restart", "names": ["cat"]}\n')
        first.flush()
        assert json.loads(first.readline())["ok"]
        first.close()
        for client in clients:
            client.close()
        assert run.row("cat")["state"] == "RUNNING"


# ---- which run


def test_the_socket_of_a_killed_launcher_is_removed_and_that_is_said(run: Steered):
    path = run.socket
    run.process.send_signal(signal.SIGKILL)
    run.process.wait()
    assert path.exists()
    done = run.shell("ps")
    assert done.returncode == 1
    assert f"removed the socket of a run that was killed: {path.stem}" in done.stderr
    assert "no run of yours is going on" in done.stderr
    assert not path.exists()


def test_of_two_runs_one_has_to_be_picked(steering: SteeringBench):
    one = steering.steer(CAT)
    ids = [one.socket.stem]  # it listens, so it has read the launch file, which changes now
    two = steering.steer('sh("exec cat", name="tac")')
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


def test_a_run_that_stands_still_is_said_not_to_answer(run: Steered):
    path = run.socket
    run.process.send_signal(signal.SIGSTOP)
    with pytest.raises(ControlError, match="does not answer"):
        connect(path, patience_s=0.2)
    run.process.send_signal(signal.SIGCONT)
    assert run.row("cat")["state"] == "RUNNING"
