"""Writes a bag with events of the services of an action, as a server that publishes them has them.

`python -m tests.support.action_events BAG`: a goal that succeeds and one that is cancelled, of
fleet_interfaces/action/ExecuteTask.
"""

from __future__ import annotations

import sys
from typing import Any

from action_msgs.msg import GoalInfo
from action_msgs.srv import CancelGoal
from fleet_interfaces.action import ExecuteTask
from fleet_interfaces.msg import TaskAssignment
from rclpy.serialization import serialize_message
from service_msgs.msg import ServiceEventInfo
from unique_identifier_msgs.msg import UUID

from launcher.bag.bag_model import Message, Topic
from launcher.bag.writer import BagWriter
from tests.support.bags import START_NS

TYPE = "fleet_interfaces/action/ExecuteTask"
TOPICS = {
    "send_goal": f"{TYPE}_SendGoal_Event",
    "get_result": f"{TYPE}_GetResult_Event",
    "cancel_goal": "action_msgs/srv/CancelGoal_Event",
}


def event(service: Any, request: Any) -> bytes:
    info = ServiceEventInfo(event_type=ServiceEventInfo.REQUEST_RECEIVED)
    return bytes(serialize_message(service.Event(info=info, request=[request])))


def goal(number: int, task: str) -> tuple[str, bytes]:
    service = ExecuteTask.Impl.SendGoalService
    values = ExecuteTask.Goal(assignment=TaskAssignment(task=task, task_id=2))
    return "send_goal", event(service, service.Request(goal_id=identity(number), goal=values))


def result(number: int) -> tuple[str, bytes]:
    service = ExecuteTask.Impl.GetResultService
    return "get_result", event(service, service.Request(goal_id=identity(number)))


def cancellation(number: int) -> tuple[str, bytes]:
    request = CancelGoal.Request(goal_info=GoalInfo(goal_id=identity(number)))
    return "cancel_goal", event(CancelGoal, request)


def identity(number: int) -> UUID:
    return UUID(uuid=[number] * 16)


def main() -> None:
    writer = BagWriter(sys.argv[1])
    names = {part: f"/execute/_action/{part}/_service_event" for part in TOPICS}
    for part, type_name in TOPICS.items():
        writer.add_topic(Topic(name=names[part], type=type_name))
    # Asked for as soon as it is sent: it has to wait until the goal is accepted.
    events = [goal(1, "work"), result(1), goal(2, "wait"), result(2), cancellation(2)]
    for number, (part, data) in enumerate(events):
        at_ns = START_NS + number * 1000
        writer.write(Message(names[part], at_ns, at_ns, 0, data))
    writer.close()


if __name__ == "__main__":
    main()
