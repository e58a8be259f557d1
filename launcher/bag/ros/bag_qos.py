"""QoS profiles in bags: of publishers when recorded, for publishers when played, overrides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from launcher.bag.bag_model import Qos
from launcher.bag.metadata import TIMES, document_in
from launcher.base.errors import UsageError
from launcher.base.model.ros_names import full_name
from launcher.ros.snapshot.ros_graph import INFINITE_NS, EndpointInfo
from launcher.ros.topics.qos import MAX_DEPTH, POLICIES, copied

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile

_FIELDS = (*POLICIES, "depth", *TIMES, "avoid_ros_namespace_conventions")
_DEPTH = 10  # where a bag does not say; rosbag2 has the same
_S = 10**9


def offered_by(info: EndpointInfo) -> Qos:
    """What a publisher offers; DDS does not report its history."""
    return {
        "history": "unknown",
        "depth": 0,
        "reliability": info.reliability.lower(),
        "durability": info.durability.lower(),
        "deadline": _time(info.deadline_ns),
        "lifespan": _time(info.lifespan_ns),
        "liveliness": info.liveliness.lower(),
        "liveliness_lease_duration": _time(info.lease_ns),
        "avoid_ros_namespace_conventions": False,
    }


def _time(ns: int) -> dict[str, int]:
    ns = INFINITE_NS if ns <= 0 else ns
    return {"sec": ns // _S, "nsec": ns % _S}


def _nanoseconds(value: Mapping[str, int]) -> int:
    """0, the default of ROS, for an infinite time."""
    ns = int(value.get("sec", 0)) * _S + int(value.get("nsec", 0))
    return 0 if ns >= INFINITE_NS // _S * _S else ns


def read_overrides(path: str) -> dict[str, Qos]:
    """Topic -> policies, from a file of rosbag2's form; UsageError with the place."""
    document = document_in(path)
    if not isinstance(document, dict):
        raise UsageError(
            f"{path} does not map topics to policies",
            hint="for example: {/chatter: {reliability: best_effort, depth: 5}}",
        )
    for topic, policies in document.items():
        _check(path, topic, policies)
    return {full_name(str(topic)): policies for topic, policies in document.items()}


def _check(path: str, topic: object, policies: object) -> None:
    place = f"{path}: {topic}"
    if not isinstance(policies, dict):
        raise UsageError(f"{place} has no policies")
    for name, value in policies.items():
        if name not in _FIELDS:
            raise UsageError(
                f"{place}: unknown policy '{name}'", hint=f"known: {', '.join(_FIELDS)}"
            )
        if name in TIMES and not isinstance(value, dict):
            raise UsageError(f"{place}: {name} is a time", hint="for example {sec: 1, nsec: 0}")
    try:
        changed(None, policies)
    except (KeyError, ValueError, TypeError) as error:
        raise UsageError(f"{place}: {error}") from None


def changed(base: QoSProfile | None, policies: Qos) -> QoSProfile:
    """A profile with some policies of a bag or of overrides; `base` is ROS's default."""
    from rclpy.duration import Duration
    from rclpy.qos import QoSProfile

    profile = QoSProfile(depth=_DEPTH) if base is None else copied(base)
    for name in POLICIES:
        word = str(policies.get(name, "unknown")).upper()
        if word != "UNKNOWN":
            kind = type(getattr(profile, name))
            if word not in kind.__members__:
                known = ", ".join(one.lower() for one in kind.__members__)
                raise ValueError(f"unknown {name} '{word.lower()}' (known: {known})")
            setattr(profile, name, kind[word])
    if (depth := int(policies.get("depth", 0))) > MAX_DEPTH:
        raise ValueError(f"a depth is at most {MAX_DEPTH}")
    if depth > 0:
        profile.depth = depth
    for name in TIMES:
        if name in policies:
            setattr(profile, name, Duration(nanoseconds=_nanoseconds(policies[name])))
    return profile


def to_play(offered: Sequence[Qos]) -> QoSProfile:
    """The profile of a player in place of all publishers that were recorded.

    Where they differ, it offers what connects to all subscriptions that any of them had: RELIABLE
    if one was, TRANSIENT_LOCAL if all were, and none of their times. What ROS does not know of a
    policy is left at its default.
    """
    if not offered:
        return changed(None, {})
    first = offered[0]
    compared = (*POLICIES, *TIMES)
    if all(one.get(name) == first.get(name) for one in offered for name in compared):
        return changed(None, {k: v for k, v in first.items() if k != "history" and _is_known(k, v)})
    reliable = any(one.get("reliability") == "reliable" for one in offered)
    latched = all(one.get("durability") == "transient_local" for one in offered)
    return changed(
        None,
        {
            "reliability": "reliable" if reliable else "best_effort",
            "durability": "transient_local" if latched else "volatile",
        },
    )


def _is_known(policy: str, value: object) -> bool:
    try:
        changed(None, {policy: value})
    except (AttributeError, KeyError, TypeError, ValueError):
        return False
    return True
