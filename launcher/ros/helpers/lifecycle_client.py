"""Reports the transitions of a lifecycle node, and requests transitions.

A node publishes each step of a transition once, to the subscriptions that it has discovered by
then, and rmw_fastrtps drops an answer to a client that the node has not discovered within 0.1 s.
Lost steps and answers are inferred from those that arrived, or from the state of the node. A
request is never sent twice: rclpy's lifecycle node exits on a transition that its state lacks.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

from lifecycle_msgs.msg import TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.node import Node

from launcher.base.model.lifecycle_transitions import TRANSITIONS

QUEUE_DEPTH = 10

Answer = Callable[["str | None"], None]


class LifecycleClient:
    """Call `poll()` regularly: it sends requests, and settles those that are overdue.

    `report` is called with each step, the label of its transition if the node sends one, and the
    time in ns.
    """

    def __init__(
        self, node: Node, name: str, report: Callable[[StateChange, str, int], None]
    ) -> None:
        self._report = report
        self._change = node.create_client(ChangeState, f"{name}/change_state")
        self._get = node.create_client(GetState, f"{name}/get_state")
        self._unsent: deque[tuple[Any, Answer]] = deque()
        self._pending: list[_PendingTransition] = []
        self._state: str | None = None
        # When a step was concluded, in ns: its event may still arrive. With clocks of other hosts
        # an event may be reported twice or, after a step back, not at all.
        self._concluded: dict[StateChange, int] = {}
        topic = f"{name}/transition_event"
        node.create_subscription(TransitionEvent, topic, self._on_event, QUEUE_DEPTH)

    def request(self, transition_id: int, label: str, answer: Answer) -> None:
        """Request a transition once the node is there; `answer` is called with an error or None."""
        message = ChangeState.Request()
        message.transition.id = transition_id
        message.transition.label = label
        self._unsent.append((message, answer))
        self.poll()

    @property
    def waits_for_node(self) -> bool:
        """Whether a request waits for the node to be there."""
        return bool(self._unsent)

    def poll(self) -> None:
        now_s = time.monotonic()
        while self._unsent and self._change.service_is_ready():
            self._send(*self._unsent.popleft(), now_s)
        for one in self._pending:
            if one.answer_future.done():
                one.request.answer(one.answer_future.result().success, now_s)
            for question in [future for future in one.questions if future.done()]:
                one.questions.remove(question)
                state = question.result().current_state.label
                self._conclude(one.request.on_state(state, now_s))
            if one.request.is_overdue(now_s):
                if one.request.succeeded:
                    self._conclude(one.request.finish())
                else:
                    self._ask_state(one)
            one.pass_on()
            if one.request.is_settled:
                self._change.remove_pending_request(one.answer_future)
                for question in one.questions:
                    self._get.remove_pending_request(question)
        self._pending = [one for one in self._pending if not one.request.is_settled]

    def _send(self, message: Any, answer: Answer, now_s: float) -> None:
        for one in self._pending:
            if one.request.succeeded is False:
                one.request.is_settled = True  # what comes now belongs to the new request
        request = TransitionRequest(message.transition.id, now_s, state=self._state)
        self._pending.append(_PendingTransition(request, answer, self._change.call_async(message)))

    def _ask_state(self, one: _PendingTransition) -> None:
        if self._get.service_is_ready():
            one.questions.append(self._get.call_async(GetState.Request()))
            if len(one.questions) > MAX_OPEN:
                self._get.remove_pending_request(one.questions.pop(0))

    def _on_event(self, message: TransitionEvent, info: dict[str, int]) -> None:
        step = StateChange(message.start_state.label, message.goal_state.label)
        if info["source_timestamp"] < self._concluded.pop(step, 0):
            return  # already reported
        now_s = time.monotonic()
        for one in self._pending:
            missed = one.request.on_event(step, now_s)
            if missed is not None:
                self._conclude(missed)
                one.pass_on()
                break
        stamp_ns = _stamp_ns(message) or info["source_timestamp"]
        self._enter(step, message.transition.label, stamp_ns)

    def _conclude(self, steps: list[StateChange]) -> None:
        for step in steps:
            self._concluded[step] = time.time_ns()
            self._enter(step, "", self._concluded[step])

    def _enter(self, step: StateChange, label: str, stamp_ns: int) -> None:
        self._state = step.goal
        self._report(step, label, stamp_ns)


def _stamp_ns(message: Any) -> int:
    """0 if the node does not set it. Since Lyrical the field is a `stamp`, with another type."""
    if hasattr(message, "stamp"):
        return int(message.stamp.sec) * 10**9 + int(message.stamp.nanosec)
    return int(message.timestamp)


class _PendingTransition:
    """A request that was sent, and the futures that belong to it."""

    def __init__(self, request: TransitionRequest, answer: Answer, answer_future: Any) -> None:
        self.request = request
        self.answer_future = answer_future
        self.questions: list[Any] = []
        self._answer: Answer | None = answer

    def pass_on(self) -> None:
        """Report the outcome, once."""
        if self._answer is not None and self.request.succeeded is not None:
            self._answer(self.request.error)
            self._answer = None


OVERDUE_S = 1.0  # an answer after its request, events after the answer, a state after a question
MAX_OPEN = 10  # questions without an answer: on a busy machine it takes long, and may be lost
MAX_QUESTIONS = 10  # answers that the node is still in the state before the transition
REFUSED = "the node refused the transition"
PRIMARY_STATES = ("unconfigured", "inactive", "active", "finalized")


class StateChange(NamedTuple):
    """Labels of the states that a node left and entered."""

    start: str
    goal: str


class TransitionRequest:
    """The state machine of a request that has been sent; no I/O.

    Times are seconds of one monotonic clock. `succeeded` is None while it is unknown; `error` is
    the reason of a failure. Once `is_settled`, no more steps are expected.
    """

    def __init__(self, transition_id: int, now_s: float, *, state: str | None = None) -> None:
        _, _, self._start, between, self._goal, _ = TRANSITIONS[transition_id]
        self._steps = (StateChange(self._start, between), StateChange(between, self._goal))
        self._back = StateChange(between, self._start)
        self._was_there = state == self._goal  # the state of the node so far, if it is known
        self._events: list[StateChange] = []
        self._due_s = now_s + OVERDUE_S
        self._questions = 0
        self.succeeded: bool | None = None
        self.error: str | None = None
        self.is_settled = False

    def answer(self, success: bool, now_s: float) -> None:
        if self.succeeded is None:
            self._set_outcome(success, None if success else REFUSED, now_s)

    def on_event(self, step: StateChange, now_s: float) -> list[StateChange] | None:
        """Take an event; return the lost steps before it. None: it is not of this transition."""
        if not self._is_ours(step):
            return None
        first, last = self._steps
        missed = [first] if step != first and first not in self._events else []
        self._events += [*missed, step]
        if step == last:
            self._set_outcome(True, None, now_s)
        elif step.start != self._start and step.goal in PRIMARY_STATES:
            self._set_outcome(False, REFUSED, now_s)
            self.is_settled = True
        return missed

    def _is_ours(self, step: StateChange) -> bool:
        if self.is_settled or step in self._events:
            return False
        is_next = bool(self._events) and step.start == self._events[-1].goal
        return is_next or step in (*self._steps, self._back)

    def is_overdue(self, now_s: float) -> bool:
        """Whether to `finish`, or to ask the node for its state; call it regularly."""
        if self.succeeded and self._steps[1] in self._events:
            self.is_settled = True
        if self.is_settled or now_s < self._due_s:
            return False
        self._due_s = now_s + OVERDUE_S
        return True

    def on_state(self, state: str, now_s: float) -> list[StateChange]:
        """Conclude from the current state of the node; return the lost steps."""
        if self.is_settled or state not in PRIMARY_STATES:
            return []  # the transition is in progress
        if self.succeeded is None and not self._decide(state, now_s):
            return []
        if self.succeeded:
            return self.finish()
        self.is_settled = True
        if self._events:
            return [StateChange(self._events[-1].goal, state)]
        return [self._steps[0], self._back] if state == self._start else []

    def finish(self) -> list[StateChange]:
        """Settle a success whose events are overdue; return the lost steps."""
        self.is_settled = True
        return [step for step in self._steps if step not in self._events]

    def _decide(self, state: str, now_s: float) -> bool:
        """Whether the state implies the answer."""
        if state == self._goal and not self._was_there:
            self._set_outcome(True, None, now_s)
        elif state != self._start:
            self._set_outcome(False, f"the node is {state}", now_s)
        elif self._events:
            self._set_outcome(False, REFUSED, now_s)
        else:  # the transition may not have begun
            self._questions += 1
            if self._questions == MAX_QUESTIONS:
                self._set_outcome(False, f"the node did not answer, and is {state}", now_s)
                self.is_settled = True
            return False
        return True

    def _set_outcome(self, succeeded: bool, error: str | None, now_s: float) -> None:
        if self.succeeded is None:
            self.succeeded, self.error = succeeded, error
        self._due_s = now_s + OVERDUE_S
