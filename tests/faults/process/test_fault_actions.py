"""`on:` in a run: what is done for a fault, and what is not."""

from __future__ import annotations

import json
import os
import signal
import sys
import tempfile
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

import pytest

from launcher.faults.actions import webhook
from launcher.faults.actions.outside_program import MAX_LINES, OutsideProgram
from launcher.posix.reactor import Reactor
from tests.support.benches import HEAD, Bench
from tests.support.controlled_run import ControlledRun
from tests.support.waiting import wait_until
from tests.support.watcher_stand_in import IN_PLACE, Reports, fault

SECRET = "open-sesame"


class WatchedRun:
    """A run of `robot` and `other` with a supervision file; `report` is what the watcher says."""

    def __init__(self, folder: Path, supervision: str) -> None:
        self.folder = folder
        file = folder / "a.launch.py"
        actions = 'sh("exec sleep 1000", name="robot"), sh("exec sleep 1000", name="other")'
        file.write_text(f"{HEAD}{IN_PLACE} {actions}\n])\n")
        self.file = folder / "a.supervise.yaml"
        self.file.write_text(supervision)
        self.reports = Reports(folder)
        env = {
            **os.environ,
            "ROS_LOG_DIR": str(folder / "log"),
            "TOKEN": SECRET,
            **self.reports.env,
        }
        words = ["-m", "launcher", str(file), "--watchful", "--no-console"]
        # Short: it holds the socket.
        self._runtime = tempfile.TemporaryDirectory(prefix="run-")
        runtime = Path(self._runtime.name)
        self.control = ControlledRun(
            [sys.executable, *words], env=env, runtime=runtime, screen=folder / "screen"
        )

    def report(self, change: str, *faults: dict[str, Any]) -> None:
        for one in faults:
            self.reports.write({"fault": one, "change": change})

    def row(self, name: str) -> dict[str, Any]:
        with self.control.connect() as connection:
            (row,) = connection.ask("ps", [name]).result["processes"]
        return row

    def taken(self) -> list[dict[str, Any]]:
        path = self.folder / "log" / "latest" / "events.jsonl"
        *whole, _ = path.read_text().split("\n") if path.exists() else [""]
        entries = map(json.loads, whole)
        return [one for one in entries if one["event"] == "fault action"]

    def wait_for_actions(self, count: int) -> list[dict[str, Any]]:
        wait_until(lambda: len(self.taken()) >= count, f"{count} actions:\n{self.control.screen}")
        return self.taken()


class Server(HTTPServer):
    """Answers with `status`, and keeps what was sent; with 0, it never answers."""

    status = 200

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.got: list[tuple[dict[str, str], Any]] = []
        self.over = threading.Event()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}/{SECRET}"


class _Handler(BaseHTTPRequestHandler):
    server: Server

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.server.got.append((dict(self.headers), body))
        if self.server.status == 0:
            self.server.over.wait(60)
            return
        self.send_response(self.server.status)
        self.send_header("Location", self.server.url)
        self.end_headers()

    do_GET = do_POST

    def log_message(self, *args: object) -> None:
        pass


@pytest.fixture
def server() -> Iterator[Server]:
    with Server() as found:
        thread = threading.Thread(target=found.serve_forever)
        thread.start()
        yield found
        found.over.set()
        found.shutdown()
        thread.join()


def test_a_fault_leads_to_actions(tmp_path: Path, server: Server):
    command = f"cat > {tmp_path}/document; env > {tmp_path}/env; echo it was written"
    run = WatchedRun(
        tmp_path,
        f"""
on:
  - {{fault: robot silent, do: restart robot}}
  - {{fault: "robot *", do: {{run: "{command}"}}}}
  - {{fault: "*", do: webhook {server.url}, headers: {{Authorization: TOKEN}}, when: healed}}
  - {{fault: "*", do: webhook $NO_SUCH_HOOK}}
  - {{fault: other *, do: stop othr}}
  - {{fault: robot silnt, do: stop robot}}
  - {{fault: robot exits, do: stop robot}}
  - {{fault: other *, do: stop other}}
  - {{fault: late *, do: {{run: "true"}}}}
""",
    )
    with run.control:
        before = run.row("robot")["pid"]
        run.reports.write({"left": [{"expectation": "robot exits", "why": "at the end"}]})
        run.reports.write({"names": ["robot silent", "other x", "late *"]})
        silent = fault("robot silent", cause="it hangs\0")
        run.report("confirmed", silent, fault("robot slow", follows="robot silent"))
        run.report("confirmed", fault("robot quiet", muted={"reason": "x", "until_s": None}))
        run.report("confirmed", fault("robot seen", acknowledged={"wall_s": 1.0, "reason": "x"}))
        run.report("confirmed", fault("late a", follows="robot quiet"))
        run.report("confirmed", fault("late b", follows="robot seen"))
        run.report("updated", fault("other x"))
        run.wait_for_actions(4)
        run.report("healed", {**silent, "healed_s": silent["confirmed_s"], "state": "healed"})
        run.report("confirmed", fault("other x"))
        taken = {one["action"]: one for one in run.wait_for_actions(7)}
        wait_until(lambda: run.row("other")["state"] == "STOPPED", "the stop of other")
        assert run.row("robot")["pid"] not in (before, None)
        run.control.ask("quit")
        run.control.exit_code()

    assert len(run.taken()) == 7
    assert taken["stop othr"]["ok"] is False and "did you mean" in taken["stop othr"]["detail"]
    oks = {one["action"].partition(" ")[0] for one in taken.values() if one["ok"]}
    assert oks == {"restart", "run", "webhook", "stop"}
    assert json.loads((tmp_path / "document").read_text()) == silent
    env = (tmp_path / "env").read_text()
    assert "LAUNCHER_FAULT=robot silent\n" in env and "LAUNCHER_FAULT_CAUSE=it hangs \n" in env
    assert "LAUNCHER_INCIDENT=1\n" in env and "LAUNCHER_RUN_ID=" in env
    ((headers, body),) = server.got
    assert (headers["Authorization"], body["state"]) == (SECRET, "healed")
    files = [path.read_text() for path in (tmp_path / "log" / "latest").iterdir()]
    screen = run.control.screen
    assert "it was written" in screen and not any(SECRET in one for one in (screen, *files))
    assert "'othr' matches no process so far" in screen
    assert "'robot silnt' matches no fault (did you mean 'robot silent'?)" in screen
    assert "'robot exits' matches no fault: 'robot exits' is left to smoke" in screen
    assert screen.count(" matches no fault") == 2
    assert "'webhook' is not used: the environment has no usable NO_SUCH_HOOK" in screen
    assert "[WARNING] [launch]: fault 'late a': " in screen  # its root is muted,
    assert "fault 'late b' follows from 'robot seen'" in screen  # and that of this one is not


def test_without_a_control_socket_nothing_is_done_which_is_a_warning(bench: Bench):
    (bench.folder / "bench.supervise.yaml").write_text("on: {fault: x, do: snapshot}\n")
    command = bench.command('sh("exec cat", name="cat")', "--no-control")
    screen, text = bench.folder / "screen", "'on' is not used: the run is not watched"
    with ControlledRun(command, env=bench.env, runtime=bench.folder, screen=screen) as run:
        wait_until(lambda: text in run.screen, "the warning")
        run.process.terminate()


def test_a_thousand_faults_and_a_command_that_does_not_end(tmp_path: Path):
    deaf = f"trap '' TERM; echo $$ >> {tmp_path}/pids; while :; do sleep 0.1; done"
    run = WatchedRun(
        tmp_path,
        f"""
on:
  - {{fault: "*", do: {{run: "{deaf}"}}, within: 500 ms, at_most: 2 per 10 min}}
  - {{fault: last, do: {{run: "{deaf}"}}, within: 10 min}}
  - {{fault: "*", do: snapshot}}
""",
    )
    with run.control:
        run.report("confirmed", *(fault(f"fault {number}") for number in range(1000)))
        taken = run.wait_for_actions(2)
        run.report("confirmed", fault("last"))
        wait_until(lambda: len((tmp_path / "pids").read_text().split()) == 3, "three commands")
        run.control.ask("quit")
        assert run.control.exit_code() == 0

    assert [(one["ok"], one["detail"]) for one in taken] == [(False, "not done within 0.5 s")] * 2
    assert run.taken()[2]["detail"] == "the run is being stopped"
    pids = [int(pid) for pid in (tmp_path / "pids").read_text().split()]
    assert not any(os.path.exists(f"/proc/{pid}") for pid in pids)
    assert run.control.screen.count("at most 2 per 600 s") == 1
    assert run.control.screen.count("'snapshot' is not used: the run is not recorded") == 1


def test_a_reload_reads_the_actions_again(tmp_path: Path):
    run = WatchedRun(tmp_path, "on: {fault: x, do: {run: exit 3}}\n")
    with run.control:
        run.report("confirmed", fault("x"))
        run.wait_for_actions(1)
        run.file.write_text("on: {fault: x, do: {run: exit 4}}\n")
        run.control.ask("reload")
        run.report("confirmed", fault("x"))
        details = [one["detail"] for one in run.wait_for_actions(2)]
    assert details == ["exit code 3", "exit code 4"]


@pytest.mark.parametrize(
    ("status", "ok"), [(204, True), (302, False), (307, False), (500, False), (0, False)]
)
def test_a_server_that_does_not_do_as_it_should(server: Server, status: int, ok: bool):
    server.status = status
    request = {"url": server.url, "headers": {"X": SECRET}, "within_s": 0.3, "body": {}}

    found, text = webhook.send(request)

    assert (found, len(server.got)) == (ok, 1)
    assert text == (f"the server has answered {status}" if status else "TimeoutError")


def test_a_server_that_is_not_there_and_a_header_that_is_none():
    request = {"url": "http://127.0.0.1:9", "headers": {}, "within_s": 5, "body": {}}
    assert webhook.send(request) == (False, "Connection refused")
    bad = {**request, "headers": {"X": f"{SECRET}\r\nY: 1"}}
    assert webhook.send(bad) == (False, "ValueError")


def test_a_flood_of_lines_is_dropped_and_a_large_document_is_read():
    lines: list[str] = []
    ends: list[tuple[bool, str]] = []
    with Reactor() as reactor:
        OutsideProgram(
            reactor,
            ["sh", "-c", "yes \x1b | head -c 300000; wc -c; kill -9 $$"],
            dict(os.environ),
            b"x" * 1_000_000,
            within_s=60,
            on_line=lines.append,
            done=lambda *end: (ends.append(end), reactor.stop()),
        )
        reactor.run()
    assert lines == [*["\\x1b"] * MAX_LINES, "(more lines are not shown)"]
    assert ends == [(False, f"signal {signal.SIGKILL.value}")]
