"""Probe: our end of the process that looks at the ROS graph for us (`launcher.ros.probe`).

A JSON object a line in both directions; answers carry the id of their request, all else is facts.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from launcher.errors import LauncherError
from launcher.ros.snapshot.graph import Endpoint, TopicGraph
from launcher.smoke.facts import GraphSeen, Message
from launcher.smoke.recorder import Recorder

READY_S = 20.0  # importing rclpy on a busy machine
GOODBYE_S = 5.0
ANSWER_ROOM_S = 2.0  # an answer says itself that it comes too late; only a dead probe takes longer


class ProbeError(LauncherError):
    """The probe could not do what it was asked to, or is gone."""


class Probe:
    """Starts the probe in an environment, records what it tells, and asks it things.

    `stderr` is a file that gets what rclpy complains about. May be asked from several threads.
    """

    def __init__(self, environment: Mapping[str, str], recorder: Recorder, stderr: Path) -> None:
        self._recorder = recorder
        self._stderr = stderr
        self._ids = itertools.count(1)
        self._answers: dict[int, dict[str, Any]] = {}
        self._changed = threading.Condition()
        self._is_ready = False
        self._has_ended = False
        self._last_graph: dict[str, Any] = {}
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

    def wait_until_ready(self, within_s: float = READY_S) -> None:
        """ProbeError if it does not come up."""
        with self._changed:
            self._changed.wait_for(lambda: self._is_ready or self._has_ended, within_s)
            if not self._is_ready:
                raise ProbeError("the ROS probe did not come up", hint=self._last_words())

    @property
    def is_alive(self) -> bool:
        """Whether it can be asked."""
        return self._is_ready and not self._has_ended

    def ask(self, do: str, *, timeout_s: float = 5.0, **fields: Any) -> dict[str, Any]:
        """The result; ProbeError with what the probe says, or if it says nothing."""
        number = next(self._ids)
        request = {"id": number, "do": do, "timeout_s": timeout_s, **fields}
        self._write(request)
        with self._changed:
            self._changed.wait_for(
                lambda: number in self._answers or self._has_ended, timeout_s + ANSWER_ROOM_S
            )
            answer = self._answers.pop(number, None)
        if answer is None:
            raise ProbeError(f"the ROS probe did not answer '{do}'", hint=self._last_words())
        if not answer.get("ok"):
            error = answer.get("error") or {}
            raise ProbeError(str(error.get("message", "refused")), hint=error.get("hint"))
        result: dict[str, Any] = answer.get("result") or {}
        return result

    def tell(self, do: str, **fields: Any) -> None:
        """Ask without waiting for the answer."""
        self._write({"id": next(self._ids), "do": do, **fields})

    def _write(self, request: dict[str, Any]) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()
        except (BrokenPipeError, ValueError):
            raise ProbeError("the ROS probe has ended", hint=self._last_words()) from None

    def close(self) -> None:
        """End it, with force if it does not go."""
        if self._process.stdin is not None:
            with contextlib.suppress(BrokenPipeError):
                self._process.stdin.close()
        try:
            self._process.wait(GOODBYE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join(GOODBYE_S)

    def _last_words(self) -> str | None:
        with contextlib.suppress(OSError):
            text = self._stderr.read_text(encoding="utf-8", errors="replace")
            lines = [line for line in text.splitlines() if line.strip()]
            return lines[-1] if lines else None
        return None

    # ---- what it tells

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            try:
                told = json.loads(line)
            except ValueError:
                continue  # something printed into the stream
            if isinstance(told, dict):
                self._take(told)
        with self._changed:
            self._has_ended = True
            self._changed.notify_all()

    def _take(self, told: dict[str, Any]) -> None:
        event = told.get("event")
        if event is None:
            with self._changed:
                self._answers[told.get("id", 0)] = told
                self._changed.notify_all()
        elif event == "ready":
            with self._changed:
                self._is_ready = True
                self._changed.notify_all()
        else:
            record: Callable[[dict[str, Any]], None] | None = {
                "graph": self._graph,
                "message": self._message,
                "failed": self._failed,
                "mismatch": self._mismatch,
                "dropped": self._dropped,
            }.get(str(event))
            if record is not None:
                record(told)

    def _graph(self, told: dict[str, Any]) -> None:
        topics = {topic["name"]: tuple(topic["types"]) for topic in told["topics"]}
        self._recorder.add_graph(
            GraphSeen(
                at_s=self._recorder.of_monotonic(told["mono"]),
                snapshot=snapshot_of(told),
                topics=topics,
            )
        )

    def _message(self, told: dict[str, Any]) -> None:
        sent = told.get("sent")
        self._recorder.add_message(
            Message(
                at_s=self._recorder.of_monotonic(told["mono"]),
                topic=told["topic"],
                content=told.get("data"),
                sent_s=None if sent is None else self._recorder.of_wall(sent),
                watch=told["sub"],
            )
        )

    def _failed(self, told: dict[str, Any]) -> None:
        hint = f" ({told['hint']})" if told.get("hint") else ""
        topic = told.get("topic") or told["sub"]
        self._recorder.add_trouble(f"{topic} could not be heard: {told['message']}{hint}")

    def _mismatch(self, told: dict[str, Any]) -> None:
        self._recorder.add_trouble(f"{told['topic']}: {told['text']}")

    def _dropped(self, told: dict[str, Any]) -> None:
        self._recorder.lose(int(told["messages"]))


def snapshot_of(told: Mapping[str, Any]) -> TopicGraph:
    """The graph that the probe tells, as the ROS verbs know it."""
    known = set(Endpoint.__dataclass_fields__)
    endpoints = [
        Endpoint(**{name: value for name, value in entry.items() if name in known})
        for entry in told["endpoints"]
        if not entry.get("ghost")
    ]
    names = [node["name"] for node in told["nodes"] for _ in range(node.get("count", 1))]
    ghosts = [node["name"] for node in told["nodes"] if node.get("ghost")]
    return TopicGraph(
        nodes=tuple(sorted(names)), endpoints=tuple(sorted(endpoints)), ghosts=tuple(sorted(ghosts))
    )
