"""Sends a goal to an action server, and gets its result or cancels it.

Without rclpy's ActionClient: rmw_fastrtps drops an answer to a client that the server has not
discovered within 0.1 s, and the ActionClient would wait for it for ever. The status topic keeps
its last message, which has what a lost answer would have reported.
"""

from __future__ import annotations

import math
import time
import uuid
from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from unique_identifier_msgs.msg import UUID

from launcher.base.ros_errors import VerbError
from launcher.ros.service_caller import ASK_AGAIN_S, NoAnswerError, ServiceCaller

STATUS = {
    GoalStatus.STATUS_ACCEPTED: "ACCEPTED",
    GoalStatus.STATUS_EXECUTING: "EXECUTING",
    GoalStatus.STATUS_CANCELING: "CANCELING",
    GoalStatus.STATUS_SUCCEEDED: "SUCCEEDED",
    GoalStatus.STATUS_CANCELED: "CANCELED",
    GoalStatus.STATUS_ABORTED: "ABORTED",
}
_CANCELED = ("CANCELING", "CANCELED")
OVER = ("SUCCEEDED", "CANCELED", "ABORTED")
_GONE_S = 2.0  # without its services, a server is gone


class Goal:
    """One goal of the action `name`, whose class is `kind`; `feedback` is called with messages."""

    def __init__(
        self,
        caller: ServiceCaller,
        kind: Any,
        name: str,
        feedback: Callable[[Any], None] | None = None,
    ) -> None:
        self._caller = caller
        self._kinds = kind.Impl
        self._name = name
        self._feedback = feedback
        self._id = UUID(uuid=list(uuid.uuid4().bytes))
        self._status: str | None = None
        self._seen_s = time.monotonic()
        self.interrupts: list[int] = []  # signals since the goal was sent
        self._clients = {
            service: caller.client(of, f"{name}/_action/{service}")
            for service, of in (
                ("send_goal", self._kinds.SendGoalService),
                ("get_result", self._kinds.GetResultService),
                ("cancel_goal", CancelGoal),
            )
        }
        caller.node.create_subscription(
            self._kinds.GoalStatusMessage,
            f"{name}/_action/status",
            self._on_status,
            qos_profile_action_status_default,
        )
        if feedback is not None:
            caller.node.create_subscription(
                self._kinds.FeedbackMessage,
                f"{name}/_action/feedback",
                self._on_feedback,
                QoSProfile(depth=1000),
            )

    @property
    def id(self) -> str:
        return bytes(self._id.uuid).hex()

    def wait_for_server(self, limit_s: float | None) -> bool:
        """Whether the server is there within the limit."""
        deadline = time.monotonic() + (math.inf if limit_s is None else limit_s)
        waits = (
            self._caller.wait_for(client, deadline - time.monotonic())
            for client in self._clients.values()
        )
        return all(waits)

    def send(self, values: object, limit_s: float) -> bool:
        """Whether the server accepts the goal; NoAnswerError."""
        self._caller.await_introduction()
        request = self._kinds.SendGoalService.Request(goal_id=self._id, goal=values)
        answer = self._clients["send_goal"].call_async(request)
        self._wait(lambda: answer.done() or self._status, limit_s)
        if answer.done():
            return bool(answer.result().accepted)
        if self._status is None:
            raise NoAnswerError(
                f"Timed out waiting for goal acceptance after {limit_s:g} seconds.",
                hint="its node may be busy or stopped: node ps",
            )
        return True

    def result(self, limit_s: float | None) -> tuple[str, Any] | None:
        """The status and the result at the end of the goal; None if it has not ended in time."""
        request = self._kinds.GetResultService.Request(goal_id=self._id)
        client, asked_s = self._clients["get_result"], -math.inf
        answers: list[Any] = []

        def is_there() -> bool:
            nonlocal asked_s
            # Asked again only if the goal has ended: until then the server keeps each request.
            is_due = time.monotonic() - asked_s > ASK_AGAIN_S
            if not answers or (self._status in OVER and is_due):
                answers.append(client.call_async(request))
                asked_s = time.monotonic()
            return any(answer.done() for answer in answers)

        if not self._wait(is_there, math.inf if limit_s is None else limit_s):
            return None
        answer = next(answer for answer in answers if answer.done()).result()
        return STATUS.get(answer.status, "UNKNOWN"), answer.result

    def cancel(self) -> None:
        """Cancel the goal; VerbError if it goes on, or has ended."""
        request = CancelGoal.Request(goal_info=GoalInfo(goal_id=self._id))
        answer = self._clients["cancel_goal"].call_async(request)

        def is_decided() -> bool:
            return answer.done() or self._status in (*_CANCELED, *OVER)

        limit_s = self._caller.answer_s
        if not self._wait(is_decided, limit_s):
            hint = f"the server did not answer within {limit_s:g} s; the goal may go on"
            raise VerbError("Failed to cancel goal", hint=hint)
        accepted = answer.done() and any(
            one.goal_id == self._id for one in answer.result().goals_canceling
        )
        if accepted or self._status in _CANCELED:
            return
        has_ended = self._status in OVER
        hint = f"it has ended: {self._status}" if has_ended else "the server refused it"
        raise VerbError("Failed to cancel goal", hint=hint)

    def _wait(self, is_done: Callable[[], object], limit_s: float) -> bool:
        """Whether it is done within the limit; VerbError if the server is gone.

        KeyboardInterrupt if there are `interrupts`.
        """
        self._seen_s = time.monotonic()

        def is_over() -> bool:
            if self.interrupts:
                self.interrupts = []
                raise KeyboardInterrupt
            if is_done():
                return True
            if all(client.service_is_ready() for client in self._clients.values()):
                self._seen_s = time.monotonic()
            elif time.monotonic() - self._seen_s > _GONE_S:
                raise VerbError(f"the server of action '{self._name}' is gone")
            return False

        self._caller.spin_until(is_over, limit_s)
        return bool(is_done())

    def _on_status(self, message: Any) -> None:
        for one in message.status_list:
            if one.goal_info.goal_id == self._id:
                self._status = STATUS.get(one.status)

    def _on_feedback(self, message: Any) -> None:
        if message.goal_id == self._id and self._feedback is not None:
            self._feedback(message.feedback)
