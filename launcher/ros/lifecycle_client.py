"""One lifecycle node as the agent sees it: its transitions, and requests for others."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Any

from lifecycle_msgs.msg import TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.node import Node

from launcher.ros.transitions import Step, TransitionRequest

QUEUE_DEPTH = 10

Answer = Callable[["str | None"], None]


class LifecycleClient:
    """Call `look()` regularly: it sends requests, and settles those that are overdue.

    `tell` is called with each step, and the label of its transition if the node sends one.
    """

    def __init__(self, node: Node, name: str, tell: Callable[[Step, str], None]) -> None:
        self._tell = tell
        self._change = node.create_client(ChangeState, f"{name}/change_state")
        self._get = node.create_client(GetState, f"{name}/get_state")
        self._unsent: deque[tuple[Any, Answer]] = deque()
        self._pending: list[_Pending] = []
        self._state: str | None = None
        # When a step was concluded, in ns: its event may still arrive. With clocks of other hosts
        # an event may be reported twice or, after a step back, not at all.
        self._concluded: dict[Step, int] = {}
        topic = f"{name}/transition_event"
        node.create_subscription(TransitionEvent, topic, self._hear, QUEUE_DEPTH)

    def request(self, transition_id: int, label: str, answer: Answer) -> None:
        """Request a transition once the node is there; `answer` is called with an error or None."""
        message = ChangeState.Request()
        message.transition.id = transition_id
        message.transition.label = label
        self._unsent.append((message, answer))
        self.look()

    def look(self) -> None:
        now_s = time.monotonic()
        while self._unsent and self._change.service_is_ready():
            self._send(*self._unsent.popleft(), now_s)
        for one in self._pending:
            if one.answer_future.done():
                one.request.answer(one.answer_future.result().success, now_s)
            if one.state_future is not None and one.state_future.done():
                state, one.state_future = one.state_future.result().current_state.label, None
                self._conclude(one.request.see(state, now_s))
            if one.request.is_overdue(now_s):
                if one.request.succeeded:
                    self._conclude(one.request.finish())
                else:
                    self._ask_state(one)
            one.pass_on()
            if one.request.is_settled:
                self._change.remove_pending_request(one.answer_future)
        self._pending = [one for one in self._pending if not one.request.is_settled]

    def _send(self, message: Any, answer: Answer, now_s: float) -> None:
        for one in self._pending:
            if one.request.succeeded is False:
                one.request.is_settled = True  # what comes now belongs to the new request
        request = TransitionRequest(message.transition.id, now_s, state=self._state)
        self._pending.append(_Pending(request, answer, self._change.call_async(message)))

    def _ask_state(self, one: _Pending) -> None:
        if one.state_future is not None:  # the answer to this question may be lost as well
            self._get.remove_pending_request(one.state_future)
            one.state_future = None
        if self._get.service_is_ready():
            one.state_future = self._get.call_async(GetState.Request())

    def _hear(self, message: TransitionEvent, info: dict[str, int]) -> None:
        step = Step(message.start_state.label, message.goal_state.label)
        if info["source_timestamp"] < self._concluded.pop(step, 0):
            return  # already reported
        now_s = time.monotonic()
        for one in self._pending:
            missed = one.request.hear(step, now_s)
            if missed is not None:
                self._conclude(missed)
                one.pass_on()
                break
        self._say(step, message.transition.label)

    def _conclude(self, steps: list[Step]) -> None:
        for step in steps:
            self._concluded[step] = time.time_ns()
            self._say(step, "")

    def _say(self, step: Step, label: str) -> None:
        self._state = step.goal
        self._tell(step, label)


class _Pending:
    """A request that was sent, and the futures that belong to it."""

    def __init__(self, request: TransitionRequest, answer: Answer, answer_future: Any) -> None:
        self.request = request
        self.answer_future = answer_future
        self.state_future: Any = None
        self._answer: Answer | None = answer

    def pass_on(self) -> None:
        """Report the outcome, once."""
        if self._answer is not None and self.request.succeeded is not None:
            self._answer(self.request.error)
            self._answer = None
