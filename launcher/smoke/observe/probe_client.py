"""Client of the ROS probe, a process that observes a ROS domain (`launcher.ros.probe`).

One JSON object per line in both directions; answers carry the id of their request.
"""

from __future__ import annotations

import contextlib
import itertools
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from launcher.base import strict_json
from launcher.base.errors import LauncherError
from launcher.ros.snapshot.ros_graph import Endpoint, TopicGraph
from launcher.smoke.observe.fact_recorder import FactRecorder
from launcher.smoke.observe.facts import GraphSeen, ObservedMessage
from launcher.smoke.observe.message_stamp import stamp_s

READY_S = 20.0  # importing rclpy on a busy machine
EXIT_S = 5.0
ANSWER_ROOM_S = 2.0  # the probe itself reports timeouts; only one that hangs takes longer


class ProbeError(LauncherError):
    """A request to the probe failed, or the probe has exited."""


class ProbeClient:
    """Starts the probe, records what it reports, and sends requests, from any thread.

    `stderr` is the file for its standard error; `on_graph` gets each graph as it is reported.
    """

    def __init__(
        self,
        environment: Mapping[str, str],
        recorder: FactRecorder,
        stderr: Path,
        on_graph: Callable[[dict[str, Any]], None] | None = None,
    ) -> None:
        self._recorder = recorder
        self._on_graph = on_graph
        self._stderr = stderr
        self._ids = itertools.count(1)
        self._answers: dict[int, dict[str, Any] | None] = {}  # those that are waited for
        self._changed = threading.Condition()
        self._is_ready = False
        self._has_ended = False
        with stderr.open("wb") as errors:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "launcher.ros.probe"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                env=dict(environment),
                start_new_session=True,
            )
        self._reader = threading.Thread(target=self._read, daemon=True, name="probe")
        self._reader.start()

    def wait_until_ready(self) -> None:
        """ProbeError if it does not start."""
        with self._changed:
            self._changed.wait_for(lambda: self._is_ready or self._has_ended, READY_S)
            if not self._is_ready:
                raise ProbeError("the ROS probe did not start", hint=self._last_line())

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def is_alive(self) -> bool:
        return self._is_ready and not self._has_ended

    def ask(self, do: str, *, timeout_s: float = 5.0, **fields: object) -> dict[str, Any]:
        """The result of a request; ProbeError if it fails or is not answered."""
        number = next(self._ids)
        request = {"id": number, "do": do, "timeout_s": timeout_s, **fields}
        self._answers[number] = None
        try:
            self._write(request)
            with self._changed:
                self._changed.wait_for(
                    lambda: self._answers[number] or self._has_ended, timeout_s + ANSWER_ROOM_S
                )
        finally:
            answer = self._answers.pop(number)
        if answer is None:
            raise ProbeError(f"the ROS probe did not answer '{do}'", hint=self._last_line())
        if not answer.get("ok"):
            error = answer.get("error") or {}
            raise ProbeError(str(error.get("message", "refused")), hint=error.get("hint"))
        result: dict[str, Any] = answer.get("result") or {}
        return result

    def send(self, do: str, **fields: object) -> None:
        """Send a request without waiting for the answer."""
        self._write({"id": next(self._ids), "do": do, **fields})

    def _write(self, request: dict[str, Any]) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(strict_json.packed(request).encode() + b"\n")
            self._process.stdin.flush()
        except (BrokenPipeError, ValueError):
            raise ProbeError("the ROS probe has ended", hint=self._last_line()) from None

    def close(self) -> None:
        """End the probe; kill it if it does not exit."""
        if self._process.stdin is not None:
            with contextlib.suppress(BrokenPipeError):
                self._process.stdin.close()
        try:
            self._process.wait(EXIT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join(EXIT_S)

    def _last_line(self) -> str | None:
        with contextlib.suppress(OSError):
            text = self._stderr.read_text(encoding="utf-8", errors="replace")
            lines = [line for line in text.splitlines() if line.strip()]
            return lines[-1] if lines else None
        return None

    # ---- what it reports

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            try:
                report = strict_json.unpacked(line)
            except ValueError:
                continue  # a library has printed to the stream
            if isinstance(report, dict):
                self._take(report)
        with self._changed:
            self._has_ended = True
            self._changed.notify_all()

    def _take(self, report: dict[str, Any]) -> None:
        event = report.get("event")
        if event is None:
            with self._changed:
                if report.get("id") in self._answers:  # else nobody waits any more
                    self._answers[report["id"]] = report
                self._changed.notify_all()
        elif event == "ready":
            with self._changed:
                self._is_ready = True
                self._changed.notify_all()
        else:
            self._record(event, report)

    def _record(self, event: str, report: dict[str, Any]) -> None:
        recorder = self._recorder
        if event == "graph":
            self._record_graph(report)
            if self._on_graph is not None:
                self._on_graph(report)
        elif event == "message":
            self._record_message(report)
        elif event == "failed":
            hint = f" ({report['hint']})" if report.get("hint") else ""
            topic = report.get("topic") or report["sub"]
            recorder.add_trouble(f"cannot subscribe to {topic}: {report['message']}{hint}")
        elif event == "mismatch":
            recorder.add_trouble(f"{report['topic']}: {report['text']}")
        elif event == "dropped":
            recorder.add_lost_messages(int(report["messages"]))

    def _record_graph(self, report: dict[str, Any]) -> None:
        topics = {topic["name"]: tuple(topic["types"]) for topic in report["topics"]}
        services = {one["name"]: tuple(one["types"]) for one in report["services"]}
        self._recorder.add(
            GraphSeen(
                at_s=self._recorder.of_monotonic(report["mono"]),
                snapshot=snapshot_of(report),
                topics=topics,
                services=services,
            )
        )

    def _record_message(self, report: dict[str, Any]) -> None:
        sent, stamp = report.get("sent"), stamp_s(report.get("data"))
        self._recorder.add(
            ObservedMessage(
                at_s=self._recorder.of_monotonic(report["mono"]),
                topic=report["topic"],
                content=report.get("data"),
                sent_s=None if sent is None else self._recorder.of_wall(sent),
                stamp_s=None if stamp is None else self._recorder.of_wall(stamp),
                watch=report["sub"],
            )
        )


def snapshot_of(report: Mapping[str, Any]) -> TopicGraph:
    """The graph in a report of the probe."""
    known = set(Endpoint.__dataclass_fields__)
    endpoints = [
        Endpoint(**{name: value for name, value in entry.items() if name in known})
        for entry in report["endpoints"]
        if not entry.get("ghost")
    ]
    names = [node["name"] for node in report["nodes"] for _ in range(node.get("count", 1))]
    ghosts = [node["name"] for node in report["nodes"] if node.get("ghost")]
    return TopicGraph(
        nodes=tuple(sorted(names)), endpoints=tuple(sorted(endpoints)), ghosts=tuple(sorted(ghosts))
    )
