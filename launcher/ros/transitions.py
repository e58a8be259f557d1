"""The state machine of a transition that was requested of a lifecycle node. No I/O.

A node publishes each step of a transition once, to the subscriptions that it has discovered by
then, and rmw_fastrtps drops an answer to a client that the node has not discovered within 0.1 s.
Lost steps and answers are inferred from those that arrived, or from the state of the node. A
request is never sent twice: rclpy's lifecycle node exits on a transition that its state lacks.
"""

from __future__ import annotations

from typing import NamedTuple

from launcher.model.lifecycle import TRANSITIONS

OVERDUE_S = 1.0  # an answer after its request, events after the answer, a state after a question
MAX_QUESTIONS = 10  # answers that the node is still in the state before the transition
REFUSED = "the node refused the transition"
PRIMARY_STATES = ("unconfigured", "inactive", "active", "finalized")


class Step(NamedTuple):
    """Labels of the states that a node left and entered."""

    start: str
    goal: str


class TransitionRequest:
    """A request that has been sent. Times are seconds of one monotonic clock.

    `succeeded` is None while it is unknown; `error` is the reason of a failure. Once `is_settled`,
    no more steps are expected.
    """

    def __init__(self, transition_id: int, now_s: float, *, state: str | None = None) -> None:
        _, _, self._start, between, self._goal, _ = TRANSITIONS[transition_id]
        self._steps = (Step(self._start, between), Step(between, self._goal))
        self._back = Step(between, self._start)
        self._was_there = state == self._goal  # the state of the node so far, if it is known
        self._heard: list[Step] = []
        self._due_s = now_s + OVERDUE_S
        self._questions = 0
        self.succeeded: bool | None = None
        self.error: str | None = None
        self.is_settled = False

    def answer(self, success: bool, now_s: float) -> None:
        if self.succeeded is None:
            self._know(success, None if success else REFUSED, now_s)

    def hear(self, step: Step, now_s: float) -> list[Step] | None:
        """Take an event; return the lost steps before it. None: it is not of this transition."""
        if not self._is_ours(step):
            return None
        first, last = self._steps
        missed = [first] if step != first and first not in self._heard else []
        self._heard += [*missed, step]
        if step == last:
            self._know(True, None, now_s)
        elif step.start != self._start and step.goal in PRIMARY_STATES:
            self._know(False, REFUSED, now_s)
            self.is_settled = True
        return missed

    def _is_ours(self, step: Step) -> bool:
        if self.is_settled or step in self._heard:
            return False
        is_next = bool(self._heard) and step.start == self._heard[-1].goal
        return is_next or step in (*self._steps, self._back)

    def is_overdue(self, now_s: float) -> bool:
        """Whether to `finish`, or to ask the node for its state; call it regularly."""
        if self.succeeded and self._steps[1] in self._heard:
            self.is_settled = True
        if self.is_settled or now_s < self._due_s:
            return False
        self._due_s = now_s + OVERDUE_S
        return True

    def see(self, state: str, now_s: float) -> list[Step]:
        """Conclude from the current state of the node; return the lost steps."""
        if self.is_settled or state not in PRIMARY_STATES:
            return []  # the transition is in progress
        if self.succeeded is None and not self._decide(state, now_s):
            return []
        if self.succeeded:
            return self.finish()
        self.is_settled = True
        if self._heard:
            return [Step(self._heard[-1].goal, state)]
        return [self._steps[0], self._back] if state == self._start else []

    def finish(self) -> list[Step]:
        """Settle a success whose events are overdue; return the lost steps."""
        self.is_settled = True
        return [step for step in self._steps if step not in self._heard]

    def _decide(self, state: str, now_s: float) -> bool:
        """Whether the state implies the answer."""
        if state == self._goal and not self._was_there:
            self._know(True, None, now_s)
        elif state != self._start:
            self._know(False, f"the node is {state}", now_s)
        elif self._heard:
            self._know(False, REFUSED, now_s)
        else:  # the transition may not have begun
            self._questions += 1
            if self._questions == MAX_QUESTIONS:
                self._know(False, f"the node did not answer, and is {state}", now_s)
                self.is_settled = True
            return False
        return True

    def _know(self, succeeded: bool, error: str | None, now_s: float) -> None:
        if self.succeeded is None:
            self.succeeded, self.error = succeeded, error
        self._due_s = now_s + OVERDUE_S
