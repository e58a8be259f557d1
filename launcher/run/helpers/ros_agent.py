"""Starts the process that sends ROS requests for the supervisor (launcher.ros.helpers.agent).

With the first request, since most launch files have none and importing rclpy is slow.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from launcher.base.model.events import (
    ChangeState,
    ComponentLoaded,
    Event,
    LoadComponent,
    StateChanged,
    TimerFired,
    TimerLost,
    TransitionSeen,
    WatchLifecycle,
)
from launcher.base.model.record import as_dict
from launcher.base.model.ros_names import full_name
from launcher.posix.reactor import Reactor
from launcher.run.helpers.helper_programs import AGENT
from launcher.run.helpers.json_lines import JsonLinesProcess

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

ENDED = "the launcher's ROS agent has ended"
GOODBYE_S = 2.0  # an agent that does not exit at EOF of its input is killed after this

Request = LoadComponent | ChangeState | WatchLifecycle


class AgentTimer:
    """A timer of the agent; `cancel()` is idempotent."""

    def __init__(self, agent: RosAgent, timer_id: int) -> None:
        self._agent = agent
        self._timer_id = timer_id

    def cancel(self) -> None:
        self._agent.cancel_timer(self._timer_id)


class RosAgent:
    """Sends requests; calls `on_event` with the answers, and `warn` with texts for the user."""

    def __init__(
        self,
        reactor: Reactor,
        env: Mapping[str, str],
        on_event: Callable[[Event], None],
        warn: Callable[[str], None],
    ) -> None:
        self._reactor = reactor
        self._on_event = on_event
        self._warn = warn
        self._pending: dict[int, LoadComponent | ChangeState] = {}
        self._containers: dict[str, str] = {}  # of components
        self._timers: set[int] = set()
        self._process = JsonLinesProcess(
            reactor,
            AGENT,
            env,
            on_message=self._answered,
            on_end=lambda code, line: self._fail_all(),
            shows_errors=True,
        )

    @property
    def is_loading(self) -> bool:
        """Whether a load request is pending, maybe in a container of another run."""
        return any(isinstance(request, LoadComponent) for request in self._pending.values())

    def send(self, request: Request) -> None:
        """Send a request; the answer is an event, which never comes if the service never exists."""
        if not isinstance(request, WatchLifecycle):
            self._pending[request.request_id] = request
        if isinstance(request, LoadComponent):
            self._containers[request.request.full_name] = request.request.container
        self._write(_as_json(request))

    def targets(self) -> list[tuple[int, str]]:
        """Requests without an answer, and the full names of the nodes or containers for them."""
        return [(number, self._target(request)) for number, request in self._pending.items()]

    def _target(self, request: LoadComponent | ChangeState) -> str:
        if isinstance(request, LoadComponent):
            return full_name(request.request.container)
        node = full_name(request.request.node)
        return full_name(self._containers.get(node, node))

    def fail(self, request_id: int, error: str) -> None:
        """Answer a request ourselves, and forget it."""
        request = self._pending.pop(request_id)
        self._write({"do": "drop", "id": request_id})
        self._on_event(_answer_to(request)(request_id=request_id, error=error))

    def use_sim_time(self, value: bool) -> None:
        self._write({"do": "use_sim_time", "value": value})

    def call_later(self, timer_id: int, delay_s: float) -> AgentTimer:
        """TimerFired after a time on the ROS clock, or TimerLost."""
        self._timers.add(timer_id)
        self._write({"do": "timer", "id": timer_id, "delay_s": delay_s})
        return AgentTimer(self, timer_id)

    def cancel_timer(self, timer_id: int) -> None:
        if timer_id in self._timers:
            self._timers.remove(timer_id)
            self._write({"do": "cancel_timer", "id": timer_id})

    def _write(self, message: dict[str, object]) -> None:
        self._process.send(message, default=_bytes_as_json)
        if self._process.has_ended:
            self._reactor.call_later(0, self._fail_all)

    def _answered(self, answer: dict[str, Any]) -> None:
        match answer:
            case {"warning": text}:
                self._warn(str(text))
            case {"timer": timer_id}:
                if timer_id in self._timers:  # else: cancelled meanwhile
                    self._timers.remove(timer_id)
                    self._on_event(TimerFired(timer_id=timer_id))
            case {"id": request_id, **rest}:
                request = self._pending.pop(request_id, None)
                if request is not None:  # else: we have given it up meanwhile
                    self._on_event(_answer_to(request)(request_id=request_id, **rest))
            case _:
                self._on_event(TransitionSeen(**answer))

    def _fail_all(self) -> None:
        pending, self._pending = self._pending, {}
        for request_id, request in pending.items():
            self._on_event(_answer_to(request)(request_id=request_id, error=ENDED))
        timers, self._timers = self._timers, set()
        for timer_id in timers:
            self._on_event(TimerLost(timer_id=timer_id, reason=ENDED))

    def close(self) -> None:
        """Stop the agent; pending requests and timers are dropped."""
        self._pending.clear()
        self._timers.clear()
        self._process.close(GOODBYE_S)


def _bytes_as_json(value: bytes) -> dict[str, list[int]]:
    return {"bytes": list(value)}  # the values of parameters are never mappings


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
    return {"do": "load", "id": request.request_id, **as_dict(request.request)}
