"""Starts the process that sends ROS requests for the supervisor (launcher.ros.agent).

With the first request, since most launch files have none and importing rclpy is slow.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping

from launcher.engine.helpers.popen import wait_or_kill
from launcher.engine.posix.reactor import Reactor
from launcher.model.events import (
    ChangeState,
    ComponentLoaded,
    Event,
    LoadComponent,
    StateChanged,
    TransitionSeen,
    WatchLifecycle,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

GOODBYE_S = 2.0  # an agent that does not exit at EOF of its input is killed after this

Request = LoadComponent | ChangeState | WatchLifecycle


class RosAgent:
    """Sends requests, and calls `on_event` with the answers."""

    def __init__(
        self, reactor: Reactor, env: Mapping[str, str], on_event: Callable[[Event], None]
    ) -> None:
        self._reactor = reactor
        self._on_event = on_event
        self._partial = b""
        self._pending: dict[int, Request] = {}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "launcher.ros.agent"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=dict(env),
            start_new_session=True,
            bufsize=0,
        )
        assert self._process.stdin is not None and self._process.stdout is not None
        self._in, self._out = self._process.stdin.fileno(), self._process.stdout.fileno()
        os.set_blocking(self._out, False)
        reactor.add_reader(self._out, self._readable)

    @property
    def is_loading(self) -> bool:
        """Whether a load request is pending, maybe in a container of another run."""
        return any(isinstance(request, LoadComponent) for request in self._pending.values())

    def send(self, request: Request) -> None:
        """Send a request; the answer is an event, which never comes if the service never exists."""
        if not isinstance(request, WatchLifecycle):
            self._pending[request.request_id] = request
        try:
            os.write(self._in, json.dumps(_as_json(request)).encode() + b"\n")
        except BrokenPipeError:
            self._fail_all()

    def _readable(self) -> None:
        chunk = os.read(self._out, 65536)
        if not chunk:
            self._reactor.remove(self._out)
            self._fail_all()
            return
        *lines, self._partial = (self._partial + chunk).split(b"\n")
        for line in lines:
            self._answered(json.loads(line))

    def _answered(self, answer: dict[str, Any]) -> None:
        request_id = answer.pop("id", None)
        if request_id is None:
            self._on_event(TransitionSeen(**answer))
            return
        request = self._pending.pop(int(request_id))
        self._on_event(_answer_to(request)(request_id=int(request_id), **answer))

    def _fail_all(self) -> None:
        pending, self._pending = self._pending, {}
        for request_id, request in pending.items():
            error = "the launcher's ROS agent has ended"
            self._on_event(_answer_to(request)(request_id=request_id, error=error))

    def close(self) -> None:
        """Stop the agent; pending requests are dropped."""
        self._reactor.remove(self._out)
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.close()
        wait_or_kill(self._process, GOODBYE_S)
        self._process.stdout.close()


def _answer_to(request: Request) -> type[ComponentLoaded] | type[StateChanged]:
    return ComponentLoaded if isinstance(request, LoadComponent) else StateChanged


def _as_json(request: Request) -> dict[str, object]:
    if isinstance(request, WatchLifecycle):
        return {"do": "watch", "node": request.node}
    if isinstance(request, ChangeState):
        change = request.request
        return {
            "do": "change_state",
            "id": request.request_id,
            "node": change.node,
            "transition_id": change.transition_id,
            "transition": change.transition,
        }
    load = request.request
    fields: dict[str, object] = {name: getattr(load, name) for name in load.__match_args__}
    return {"do": "load", "id": request.request_id, **fields}
