"""Options that several ROS verbs have, with their defaults."""

from __future__ import annotations

from typing import Any

# (what is typed, options of its verb, those that differ from their defaults)
Line = tuple[str, dict[str, Any], dict[str, Any]]

BASE = {"domain": None, "spin_time": None, "json": False, "no_observer": False}
QOS = dict.fromkeys(
    [
        "qos_profile",
        "qos_depth",
        "qos_reliability",
        "qos_durability",
        "qos_liveliness",
        "qos_history",
        "qos_liveliness_lease_duration_seconds",
    ]
)
