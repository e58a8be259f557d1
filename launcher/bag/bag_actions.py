"""Actions in bags: five topics, three of them with the events of services."""

from __future__ import annotations

import re
from collections.abc import Mapping

from launcher.bag.bag_model import Topic
from launcher.bag.bag_services import EVENTS

_BEFORE = "/_action/"
STATUS_TYPE = "action_msgs/msg/GoalStatusArray"
# What follows the name of the action -> the type of such a topic.
_TYPES: Mapping[str, re.Pattern[str]] = {
    "feedback": re.compile(r"(.+/action/.+)_FeedbackMessage"),
    "status": re.compile(STATUS_TYPE),
    f"send_goal{EVENTS}": re.compile(r"(.+/action/.+)_SendGoal_Event"),
    f"cancel_goal{EVENTS}": re.compile(r"action_msgs/srv/CancelGoal_Event"),
    f"get_result{EVENTS}": re.compile(r"(.+/action/.+)_GetResult_Event"),
}
TOPICS = ("feedback", "status")
SERVICES = ("send_goal", "cancel_goal", "get_result")


def action_of(topic: str, type_name: str) -> str | None:
    """The action that a topic of this name and type belongs to."""
    name, _, part = topic.partition(_BEFORE)
    pattern = _TYPES.get(part)
    return name if name and pattern is not None and pattern.fullmatch(type_name) else None


def status_topic(action: str) -> str:
    return f"{action}{_BEFORE}status"


def source_of(topic: str, type_name: str) -> str:
    """The action or the service that a topic belongs to, or the topic itself."""
    return action_of(topic, type_name) or topic.removesuffix(EVENTS)


def renamed(topic: Topic, names: Mapping[str, str]) -> str:
    """Its new name; that of an action or a service renames all topics of it."""
    source = source_of(topic.name, topic.type)
    if topic.name in names or source not in names:
        return names.get(topic.name, topic.name)
    return names[source] + topic.name.removeprefix(source)


def part_of(topic: Topic) -> str:
    """Of a topic of an action: `feedback`, `send_goal`."""
    return topic.name.partition(_BEFORE)[2].removesuffix(EVENTS)


def type_of(topic: Topic) -> str:
    """The type of the action of a topic; empty if the topic does not show it."""
    found = _TYPES[topic.name.partition(_BEFORE)[2]].fullmatch(topic.type)
    return found[1] if found is not None and found.re.groups else ""
