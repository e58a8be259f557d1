"""The QoS of our own endpoints: from options, from words, or fitted to publishers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from launcher.base.ros_errors import VerbError
from launcher.ros.messages.interfaces import full_type
from launcher.ros.snapshot.qos_matching import Mismatch
from launcher.ros.snapshot.ros_graph import INFINITE_NS, Direction, Endpoint

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile

# room for a second of a fast topic while Python is busy elsewhere
LISTEN_DEPTH = 5000
MAX_DEPTH = 2**31 - 1

POLICIES = {
    "reliability": ("system_default", "reliable", "best_effort", "best_available"),
    "durability": ("system_default", "transient_local", "volatile", "best_available"),
    "liveliness": ("system_default", "automatic", "manual_by_topic", "best_available"),
    "history": ("system_default", "keep_last", "keep_all"),
}
PRESETS = (
    "system_default",
    "sensor_data",
    "services_default",
    "parameters",
    "parameter_events",
    "action_status_default",
    "best_available",
    "default",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class QosOptions:
    """Policies to use instead of those of a profile, by their names; None: as in the profile."""

    preset: str | None = None
    depth: int | None = None
    reliability: str | None = None
    durability: str | None = None
    liveliness: str | None = None
    history: str | None = None
    lease_s: float | None = None


def from_options(options: QosOptions, base: QoSProfile) -> QoSProfile:
    """The base profile, or the preset of the options, changed by the other options."""
    from rclpy.duration import Duration
    from rclpy.qos import QoSPresetProfiles

    profile = copied(base)
    if options.preset:
        profile = copied(QoSPresetProfiles[options.preset.upper()].value)
    if options.depth is not None:
        profile.depth = options.depth
    for name in POLICIES:
        if word := getattr(options, name):
            setattr(profile, name, type(getattr(profile, name))[word.upper()])
    if options.lease_s is not None:
        profile.liveliness_lease_duration = Duration(nanoseconds=int(options.lease_s * 1e9))
    return profile


def publisher_options(found: Iterable[Mismatch]) -> list[str]:
    """The options with which a publisher offers what these subscriptions request."""
    faults = (fault for mismatch in found for fault in mismatch.faults)
    options = {
        f"--qos-{fault.policy.lower()} {fault.requested.lower()}": None
        for fault in faults
        if fault.policy.lower() in POLICIES
    }
    return list(options)


def from_words(words: Mapping[str, Any], depth: int) -> QoSProfile:
    """Exactly the profile of the words, which are those of `topic info -v`; else ROS's default.

    Times are `deadline_s` and `lease_s`. VerbError for an unknown word.
    """
    from rclpy.duration import Duration
    from rclpy.qos import QoSProfile

    named = {name: _policy(name, words.get(name)) for name in POLICIES}
    for name in words:
        if name not in (*POLICIES, "deadline_s", "lease_s"):
            raise VerbError(f"unknown QoS policy '{name}'", hint=f"known: {', '.join(POLICIES)}")
    options = QosOptions(depth=depth, lease_s=words.get("lease_s"), **named)
    profile = from_options(options, QoSProfile(depth=depth))
    if words.get("deadline_s") is not None:
        profile.deadline = Duration(nanoseconds=int(words["deadline_s"] * 1e9))
    return profile


def _policy(name: str, word: str | None) -> str | None:
    if word is not None and str(word).lower() not in POLICIES[name]:
        known = ", ".join(choice.upper() for choice in POLICIES[name])
        raise VerbError(f"unknown {name} '{word}'", hint=f"one of {known}")
    return None if word is None else str(word)


def to_words(profile: QoSProfile) -> dict[str, Any]:
    """The words of a profile, as `from_words` takes them, and its depth."""
    times = {"deadline_s": profile.deadline, "lease_s": profile.liveliness_lease_duration}
    return {
        **{name: getattr(profile, name).name for name in POLICIES},
        "depth": profile.depth,
        **{name: time.nanoseconds / 1e9 or None for name, time in times.items()},
    }


def endpoint_of(
    profile: QoSProfile, direction: Direction, topic: str, type_name: str, *, node: str
) -> Endpoint:
    """An endpoint of ours as the graph would show it, to compare it with others."""
    return Endpoint(
        topic=topic,
        node=node,
        direction=direction.value,
        type=full_type(type_name),
        reliability=profile.reliability.name,
        durability=profile.durability.name,
        liveliness=profile.liveliness.name,
        deadline_ns=profile.deadline.nanoseconds or INFINITE_NS,
        lease_ns=profile.liveliness_lease_duration.nanoseconds or INFINITE_NS,
    )


def copied(profile: QoSProfile) -> QoSProfile:
    from rclpy.qos import QoSProfile

    names = [name.removeprefix("_") for name in QoSProfile.__slots__]
    return QoSProfile(**{name: getattr(profile, name) for name in names})


def listening(
    publishers: Iterable[Endpoint], depth: int = LISTEN_DEPTH
) -> tuple[QoSProfile, list[str]]:
    """A profile that connects to all publishers, and the notes of ros2cli where they differ.

    As strong as all of them allow: RELIABLE only if all are, TRANSIENT_LOCAL only if all are.
    """
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    known = list(publishers)
    notes: list[str] = []

    def fitted(strong: Any, weak: Any, offered: list[str]) -> Any:
        count = offered.count(strong.name)
        if offered and count == len(offered):
            return strong
        if count:
            kind = f"QoS{type(strong).__name__.removeprefix('QoS')}"
            notes.append(
                f"Some, but not all, publishers are offering {kind}.{strong.name}. "
                f"Falling back to {kind}.{weak.name} as it will connect to all publishers"
            )
        return weak

    reliability, durability = ReliabilityPolicy, DurabilityPolicy
    profile = QoSProfile(
        depth=depth,
        reliability=fitted(
            reliability.RELIABLE, reliability.BEST_EFFORT, [e.reliability for e in known]
        ),
        durability=fitted(
            durability.TRANSIENT_LOCAL, durability.VOLATILE, [e.durability for e in known]
        ),
    )
    return profile, notes
