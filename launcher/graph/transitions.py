"""Transitions that a launch file asks of a lifecycle node, reported even where a message is lost.

A node publishes each transition once, to the subscriptions that it has discovered by then, and
rmw_fastrtps drops an answer to a client that the node has not discovered within 0.1 s. Where an
answer or an event is overdue, the state of the node decides what has happened. A request is never
sent twice: rclpy's lifecycle node dies of a transition that its state does not have.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

from lifecycle_msgs.msg import TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.node import Node

from launcher.model.lifecycle import TRANSITIONS, transition_steps

OVERDUE_S = 1.0  # an answer after its request, events after the answer, the state after a question
MAX_QUESTIONS = 10  # answered with the state from which the transition should have begun
QUEUE_DEPTH = 10
REFUSED = "the node refused the transition"
PRIMARY_STATES = ("unconfigured", "inactive", "active", "finalized")


class Step(NamedTuple):
    """One event: the states that a node left and entered, by their labels."""

    start: str
    goal: str


class LifecycleNodeClient:
    """One lifecycle node: hears its transitions and asks it for others. Call `look()` regularly.

    `tell` gets each step, and the label of its transition where the node gives one.
    """

    def __init__(self, node: Node, name: str, tell: Callable[[Step, str], None]) -> None:
        self._tell = tell
        self._change = node.create_client(ChangeState, f"{name}/change_state")
        self._state = node.create_client(GetState, f"{name}/get_state")
        self._requests: list[_Request] = []
        self._inferred: dict[Step, int] = {}  # when, in ns: these may still arrive late
        topic = f"{name}/transition_event"
        node.create_subscription(TransitionEvent, topic, self._hear, QUEUE_DEPTH)

    def request(self, transition_id: int, label: str, answer: Callable[[str | None], None]) -> None:
        """Ask for a transition when the node is there; `answer` gets an error or None."""
        message = ChangeState.Request()
        message.transition.id = transition_id
        message.transition.label = label
        self._requests.append(_Request(message, answer, self._change, self._state))
        self.look()

    def look(self) -> None:
        """Send what can be sent, and settle what is overdue."""
        now_s = time.monotonic()
        for request in self._requests:
            for step in request.look(now_s):
                self._inferred[step] = time.time_ns()
                self._tell(step, "")
        self._requests = [request for request in self._requests if not request.is_settled]

    def _hear(self, message: TransitionEvent, info: dict[str, int]) -> None:
        step = Step(message.start_state.label, message.goal_state.label)
        inferred_ns = self._inferred.pop(step, 0)
        if info["source_timestamp"] < inferred_ns:
            return  # told already
        for request in self._requests:
            request.heard.append(step)
        self._tell(step, message.transition.label)


class _Request:
    """One transition, from the launch file's request to its last event."""

    def __init__(
        self, message: Any, answer: Callable[[str | None], None], change: Any, state: Any
    ) -> None:
        number = message.transition.id
        self.heard: list[Step] = []
        self.is_settled = False
        self._message = message
        self._transition = TRANSITIONS[number]
        self._steps = [Step(start, goal) for _, start, goal in transition_steps(number)]
        self._answer = answer
        self._change, self._state = change, state
        self._sent: Any = None
        self._asked: Any = None
        self._due_s = 0.0
        self._questions = 0
        self._succeeded: bool | None = None

    def look(self, now_s: float) -> list[Step]:
        """Go on as far as possible; the steps that have happened without having been heard."""
        if self._sent is None:
            if self._change.service_is_ready():
                self._sent = self._change.call_async(self._message)
                self._due_s = now_s + OVERDUE_S
            return []
        if self._succeeded is None and self._sent.done():
            success = self._sent.result().success
            self._answered(success, None if success else REFUSED, now_s)
        if self._succeeded and not self._missing():
            self.is_settled = True
        elif self._succeeded and now_s >= self._due_s:
            self.is_settled = True
            return self._missing()
        elif not self._succeeded and self._asked is not None and self._asked.done():
            state, self._asked = self._asked.result().current_state.label, None
            return self._failed(state) if self._succeeded is False else self._judge(state, now_s)
        elif not self._succeeded and now_s >= self._due_s:
            self._ask_state(now_s)
        return []

    def _answered(self, succeeded: bool, error: str | None, now_s: float) -> None:
        self._succeeded = succeeded
        self._due_s = now_s + OVERDUE_S
        self._answer(error)

    def _missing(self) -> list[Step]:
        return [step for step in self._steps if step not in self.heard]

    def _ask_state(self, now_s: float) -> None:
        self._due_s = now_s + OVERDUE_S
        if self._asked is not None:  # the answer to this question may be lost as well
            self._state.remove_pending_request(self._asked)
            self._asked = None
        if self._state.service_is_ready():
            self._asked = self._state.call_async(GetState.Request())

    def _judge(self, state: str, now_s: float) -> list[Step]:
        """What the state says while there is no answer."""
        _, _, start, between, goal, _ = self._transition
        if state == goal:
            self._answered(True, None, now_s)
        elif state not in (start, between):
            self._answered(False, f"the node is {state}", now_s)
        elif Step(between, start) in self.heard:
            self._answered(False, REFUSED, now_s)
        elif state == start:
            self._questions += 1
            if self._questions == MAX_QUESTIONS:
                self._answered(False, f"the node did not answer, and is {state}", now_s)
                self.is_settled = True
        return []

    def _failed(self, state: str) -> list[Step]:
        """The steps back that were not heard: a failed transition ends in a state, too."""
        if state not in PRIMARY_STATES:
            return []  # it is still handling its error
        self.is_settled = True
        if self.heard:
            last = self.heard[-1].goal
            return [] if last == state else [Step(last, state)]
        start, between = self._transition.start, self._transition.between
        return [Step(start, between), Step(between, start)] if state == start else []
