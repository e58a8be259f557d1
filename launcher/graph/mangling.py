"""Mangling: how topics and types of ROS are named in DDS."""

from __future__ import annotations

from typing import NamedTuple

_REQUEST, _REPLY = "Request", "Reply"


class RosName(NamedTuple):
    """A name in ROS and what it is there: `rt` topic, `rq` request, `rr` reply of a service."""

    channel: str
    name: str


def ros_name(topic: str) -> RosName | None:
    """What `rt/chatter` or `rq/switchRequest` is in ROS; None if it is no name of ROS."""
    channel, slash, name = topic.partition("/")
    if not slash or channel not in ("rt", "rq", "rr"):
        return None
    ending = {"rq": _REQUEST, "rr": _REPLY}.get(channel, "")
    return RosName(channel, "/" + name.removesuffix(ending))


def ros_type(type_name: str, channel: str = "rt") -> str:
    """`std_msgs::msg::dds_::String_` -> `std_msgs/msg/String`; what is no type of ROS as it is."""
    if "::dds_::" not in type_name or not type_name.endswith("_"):
        return type_name
    plain = type_name.replace("::dds_::", "::")[:-1].replace("::", "/")
    if channel == "rt":
        return plain
    return plain.removesuffix("_Request").removesuffix("_Response")
