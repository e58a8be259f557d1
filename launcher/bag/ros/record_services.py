"""The services of `bag record`, below the name of its node, and its events."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

from launcher.bag.ros.control_services import (
    ControlServices,
    Handler,
    answer,
    message_type,
    time_ns,
)
from launcher.base.errors import LauncherError
from launcher.base.model.ros_names import full_name

if TYPE_CHECKING:
    from rclpy.node import Node

    from launcher.bag.ros.recorder import Recorded

NODE = "rosbag2_recorder"
IN_RECORDING = "Called record(uri) while already in recording."
_NODE_TIME, _PUBLISH_TIME, _RECEIVE_TIME = 0, 1, 2
# Codes of SplitBagfile and Resume.
_NOT_RECORDING, _INVALID_SPLIT_MODE = 1, 2
_INVALID_RESUME_MODE = 1

Action = Callable[[], None]


class Controlled(Protocol):
    """What the services do with a recording; LauncherError."""

    paused: bool
    discovers: bool
    times: MessageTimes

    @property
    def takes_snapshots(self) -> bool: ...

    @property
    def is_recording(self) -> bool: ...

    def begin(self, folder: str) -> None: ...

    def end(self) -> None: ...

    def split(self) -> None: ...

    def snapshot(self) -> None: ...

    def at(self, due_ns: int | None, action: Action) -> None:
        """Do it at this time of the node, or at once if it has passed or is None."""


class MessageTimes:
    """The times of the last messages, and what is due when messages have some time.

    Times are pairs, of publishing and of receiving; the topic "" stands for all.
    """

    def __init__(self) -> None:
        self._last: dict[str, tuple[int, int]] = {}
        self._due: dict[str, tuple[str, int, int, Action]] = {}

    def note(self, topic: str, publish_ns: int, receive_ns: int) -> None:
        """A message has come. Does what is due."""
        times = publish_ns, receive_ns
        self._last[topic] = self._last[""] = times
        for name, (tracked, mode, due_ns, action) in list(self._due.items()):
            if tracked in ("", topic) and times[mode == _RECEIVE_TIME] >= due_ns:
                del self._due[name]
                action()

    def when(self, name: str, topic: str, mode: int, due_ns: int, action: Action) -> None:
        """Do it when a message of the topic has this time; what had this name is forgotten."""
        self._due.pop(name, None)
        last = self._last.get(topic)
        if last is not None and last[mode == _RECEIVE_TIME] >= due_ns:
            action()
        else:
            self._due[name] = topic, mode, due_ns, action

    def clear(self) -> None:
        self._last.clear()
        self._due.clear()


class RecorderServices(ControlServices):
    """They may stop the recording and begin another one."""

    def __init__(self, node: Node, run: Controlled) -> None:
        self._run = run
        handlers: dict[str, tuple[str, Handler]] = {
            "record": ("Record", self._record),
            "stop": ("Stop", self._stop),
            "start_discovery": ("StartDiscovery", self._start_discovery),
            "stop_discovery": ("StopDiscovery", self._stop_discovery),
            "is_discovery_running": ("IsDiscoveryRunning", self._is_discovering),
            "split_bagfile": ("SplitBagfile", self._split),
            "pause": ("Pause", self._pause),
            "resume": ("Resume", self._resume),
            "is_paused": ("IsPaused", self._is_paused),
        }
        if run.takes_snapshots:
            handlers["snapshot"] = ("Snapshot", self._snapshot)
        super().__init__(node, handlers)

    def _record(self, request: Any, response: Any) -> None:
        if self._run.is_recording:
            answer(response, IN_RECORDING)
            return
        try:
            due_ns = time_ns(request, "start_time")
            self._run.at(due_ns, lambda: self._run.begin(request.uri))
        except LauncherError as error:
            answer(response, error.message)
        else:
            answer(response)

    def _stop(self, request: Any, response: Any) -> None:
        if self._run.is_recording:
            self._run.end()
            answer(response)
        else:
            answer(response, "Recorder is already stopped.")

    def _start_discovery(self, request: Any, response: Any) -> None:
        if not self._run.is_recording:
            answer(response, "Recorder is not currently recording.")
        elif self._is_running:
            answer(response, "Discovery is already running.")
        else:
            self._run.discovers = True
            answer(response)

    def _stop_discovery(self, request: Any, response: Any) -> None:
        if self._is_running:
            self._run.discovers = False
            answer(response)
        else:
            answer(response, "Discovery is not running.")

    def _is_discovering(self, request: Any, response: Any) -> None:
        response.running = self._is_running

    @property
    def _is_running(self) -> bool:
        return self._run.is_recording and self._run.discovers

    def _split(self, request: Any, response: Any) -> None:
        mode, due_ns = getattr(request, "split_mode", _NODE_TIME), time_ns(request, "split_time")
        if mode not in (_NODE_TIME, _PUBLISH_TIME, _RECEIVE_TIME):
            answer(response, "Invalid split_mode for SplitBagfile request.", _INVALID_SPLIT_MODE)
        elif not self._run.is_recording:
            text = "Called 'SplitBagfile' request while not in recording. Request ignored."
            answer(response, text, _NOT_RECORDING)
        else:
            self._do("split", mode, due_ns, request, self._split_now)
            answer(response)

    def _split_now(self) -> None:
        if self._run.is_recording:
            self._run.split()

    def _resume(self, request: Any, response: Any) -> None:
        mode, due_ns = getattr(request, "resume_mode", _NODE_TIME), time_ns(request, "resume_time")
        if mode not in (_NODE_TIME, _PUBLISH_TIME, _RECEIVE_TIME):
            answer(response, "Invalid resume_mode for Resume request.", _INVALID_RESUME_MODE)
        else:
            self._do("resume", mode, due_ns, request, self._resume_now)
            answer(response)

    def _resume_now(self) -> None:
        self._run.paused = False

    def _do(self, name: str, mode: int, due_ns: int | None, request: Any, action: Action) -> None:
        """At a time of the node, or of messages."""
        if mode == _NODE_TIME or due_ns is None:
            self._run.at(due_ns, action)
        else:
            topic = full_name(request.tracking_topic_name)
            self._run.times.when(name, topic, mode, due_ns, action)

    def _pause(self, request: Any, response: Any) -> None:
        self._run.paused = True

    def _is_paused(self, request: Any, response: Any) -> None:
        response.paused = self._run.paused

    def _snapshot(self, request: Any, response: Any) -> None:
        response.success = self._run.is_recording
        if response.success:
            self._run.snapshot()


class RecorderEvents:
    """Publishes splits of files, and what was lost, at most every `period_s` (None: never)."""

    def __init__(self, node: Node, period_s: float | None) -> None:
        self._node = f"/{node.get_name()}"
        self._period_s = period_s
        self._next_s = 0.0
        self._known: dict[str, tuple[int, int]] = {}
        self._splits, self._split = self._publisher(node, "WriteSplitEvent", "write_split")
        self._lost, self._event = self._publisher(
            node, "MessagesLostEvent", "rosbag2_messages_lost"
        )
        self._statistic = message_type("MessagesLostEventTopicStat")

    @staticmethod
    def _publisher(node: Node, type_name: str, topic: str) -> tuple[Any, Any]:
        if (kind := message_type(type_name)) is None:
            return None, None
        return node.create_publisher(kind, f"events/{topic}", 10), kind

    def split(self, closed: str, opened: str) -> None:
        if self._splits is not None:
            event = self._split(closed_file=closed, opened_file=opened, node_name=self._node)
            self._splits.publish(event)

    def publish_lost(self, topics: Mapping[str, Recorded], *, now: bool = False) -> None:
        """What was lost since the last event, if it is time."""
        if self._lost is None or self._period_s is None:
            return
        if not now and time.monotonic() < self._next_s:
            return
        self._next_s = time.monotonic() + self._period_s
        found = []
        for name, one in topics.items():
            transport, recorder = self._known.get(name, (0, 0))
            if (one.lost, one.dropped) == (transport, recorder):
                continue
            self._known[name] = one.lost, one.dropped
            found.append(
                self._statistic(
                    topic_name=name,
                    messages_lost_in_transport=one.lost - transport,
                    messages_lost_in_recorder=one.dropped - recorder,
                )
            )
        if found:
            self._lost.publish(self._event(node_name=self._node, messages_lost_statistics=found))

    def forget(self) -> None:
        """Another recording begins."""
        self._known.clear()
