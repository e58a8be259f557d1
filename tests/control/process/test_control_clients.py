"""Broken, slow and many clients of the control socket do not harm a run."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import threading

import psutil
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from launcher.control.client import Connection
from launcher.control.protocol import REQUEST_LIMIT
from tests.support.benches import ControlBench
from tests.support.controlled_run import TIMEOUT_S, ControlledRun
from tests.support.examples import examples
from tests.support.raw_client import RawClient, error_of
from tests.support.waiting import wait_until

pytestmark = pytest.mark.thorough

CAT = 'sh("exec cat", name="cat")'

DOCUMENTS = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=9), inner),
    max_leaves=20,
)
VERBS = st.sampled_from(["ps", "top", "logs", "events", "info", "plan", "help", "level", "grep"])
# These change what the test looks at; hypothesis takes texts from the modules that are loaded.
CHANGING = ("quit", "exit", "q", "stop", "kill", "pause", "restart")
REQUESTS = st.fixed_dictionaries(
    {"verb": VERBS | st.text(max_size=9).filter(lambda verb: verb not in CHANGING)},
    optional={
        "protocol": st.integers(0, 3) | DOCUMENTS,
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
    max_examples=examples(150),
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_no_request_harms_a_run(run: ControlledRun, words: list[bytes]):
    with contextlib.suppress(OSError), RawClient(run.socket) as client:
        for data in words:
            client.send(data)
    assert run.row("cat")["state"] == "RUNNING"
    assert run.process.poll() is None
    assert "Traceback" not in run.screen


def test_a_request_may_come_byte_by_byte_while_others_are_served(run: ControlledRun):
    with RawClient(run.socket) as slow, RawClient(run.socket) as other:
        for byte in b'{"id": 1, "verb": "ps"}\n':
            other.send(b'{"verb": "ps"}\n')
            assert other.read()["ok"]
            slow.send(bytes([byte]))
        assert slow.read()["id"] == 1


def test_a_line_without_an_end_is_refused_at_its_limit(run: ControlledRun):
    with RawClient(run.socket) as client:
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            for _ in range(1000):
                client.send(b"x" * REQUEST_LIMIT)
        answer = client.read()
        assert error_of(answer) == "bad-request"
        assert "at most 65536 bytes" in answer["error"]["message"]
        with contextlib.suppress(ConnectionResetError):
            assert client.read() is None
    assert run.row("cat")["state"] == "RUNNING"


def test_a_client_that_shuts_down_its_sending_side_still_gets_its_answers(run: ControlledRun):
    run.ask("ps")
    before = run.open_files()
    with RawClient(run.socket) as client:
        client.send(b'{"id": 1, "verb": "ps"}\n{"id": 2, "verb": "restart", "names": ["cat"]}\n')
        client.socket.shutdown(socket.SHUT_WR)
        assert [client.read()["id"], client.read()["id"]] == [1, 2]
        assert client.read() is None
    with RawClient(run.socket) as client:
        client.send(b'{"id": 3, "verb": "events", "options": {"follow": true, "history": false}}\n')
        client.socket.shutdown(socket.SHUT_WR)
        run.ask_text("restart", "cat")
        while client.read()["item"]["event"] != "ended":
            pass  # it is told what happens although it has nothing more to say
    wait_until(lambda: run.open_files() <= before, "the connection given back")


def test_a_hundred_clients_are_served_while_the_output_flows(control_bench: ControlBench):
    lines = 20_000
    writer = f'sh("read go; seq {lines}; echo over", name="writer")'
    with control_bench.launch(f"{writer}, {CAT}") as run:
        path = run.socket
        answered = []

        def client(number: int) -> None:
            with Connection(path, timeout_s=TIMEOUT_S) as connection:
                for verb in ("ps", "logs", "info", "events", "ps"):
                    names = ["writer"] if verb in ("logs", "info") else []
                    answer = connection.ask(verb, names, timeout_s=60)
                    assert answer.result
                answered.append(number)

        clients = [threading.Thread(target=client, args=(number,)) for number in range(100)]
        run.ask_text("send", "writer", text="go")
        for thread in clients:
            thread.start()
        for thread in clients:
            thread.join()
        run.wait_for("[writer-1] over\n")
        assert len(answered) == 100
        shown = [line for line in run.screen.splitlines() if line.startswith("[writer-1] ")]
        assert shown == [*(f"[writer-1] {n}" for n in range(1, lines + 1)), "[writer-1] over"]


def test_only_the_follower_that_does_not_read_loses_lines(control_bench: ControlBench):
    lines = 50_000
    writer = f'sh("read go; seq {lines}; echo over", name="writer")'
    with control_bench.launch(f"{writer}, {CAT}") as run, run.connect() as lazy:
        request = lazy.send("logs", ["writer"], follow=True, lines=0)
        # Answered in turn, so after this the other one is served.
        lazy.ask("ps")
        run.ask_text("send", "writer", text="go")
        run.wait_for("[writer-1] over\n")
        shown = [line for line in run.screen.splitlines() if line.startswith("[writer-1] ")]
        assert shown[:-1] == [f"[writer-1] {n}" for n in range(1, lines + 1)]
        got = dropped = 0
        while got + dropped < lines + 1:
            answer = lazy.read(TIMEOUT_S)
            assert answer["id"] == request
            if "dropped" in answer["item"]:
                dropped += answer["item"]["dropped"]
            else:
                got += 1
        assert dropped > 0
        assert got + dropped == lines + 1


def test_a_follower_gets_all_that_was_before(control_bench: ControlBench):
    often = 'sh("exit 0", respawn=True, respawn_delay=0.0, name="often")'
    with control_bench.launch(f"{often}, {CAT}") as run:
        path = control_bench.folder / "log/latest/events.jsonl"
        wait_until(
            lambda: path.exists() and path.stat().st_size > 600_000,
            "more than waits for a slow client",
            300.0,
        )
        run.ask_text("stop", "often-1")
        known = [line for line in path.read_text().splitlines() if '"resources"' not in line]
        with RawClient(run.socket) as client:
            client.send(b'{"verb": "events", "id": 1, "options": {"follow": true}}\n')
            client.send(b'{"verb": "ps", "id": 2}\n')  # is answered when the client has read
            items = []
            while (answer := client.read())["id"] == 1:
                items.append(answer["item"])
        # What happens while a slow client reads may be dropped, but nothing that was before.
        got = {item["monotonic_s"] for item in items if "dropped" not in item}
        assert {json.loads(line)["monotonic_s"] for line in known[-4000:]} <= got


def test_a_client_that_asks_and_never_reads_is_not_served_for_ever(run: ControlledRun):
    with RawClient(run.socket) as greedy:
        greedy.socket.settimeout(0.5)
        with contextlib.suppress(TimeoutError):
            for _ in range(100_000):
                greedy.send(b'{"verb": "help"}\n')
        resident = psutil.Process(run.process.pid).memory_info().rss
        assert resident < 200_000_000  # bytes: what waits for it is bounded
        assert run.row("cat")["state"] == "RUNNING"


def test_clients_take_no_descriptors_that_processes_need(control_bench: ControlBench):
    with control_bench.launch(CAT, files=80) as run:
        path = run.socket
        clients = []
        for _ in range(100):
            client = socket.socket(socket.AF_UNIX)
            client.connect(os.fspath(path))
            clients.append(client)
        run.wait_for("cannot accept clients: Too many open files")
        first = clients[0].makefile("rwb")
        first.readline()
        first.write(b'{"verb": "restart", "names": ["cat"]}\n')
        first.flush()
        assert json.loads(first.readline())["ok"]
        first.close()
        for client in clients:
            client.close()
        assert run.row("cat")["state"] == "RUNNING"
