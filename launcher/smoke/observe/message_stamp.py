"""The time with which a message begins."""

from __future__ import annotations

from collections.abc import Mapping

_NANOS = 1e9


def stamp_s(content: object) -> float | None:
    """Its `header.stamp` or first field, in seconds; None if it is no time, or not set.

    `content` is the message as plain data, in the order of its fields.
    """
    first = next(iter(content.values()), None) if isinstance(content, Mapping) else None
    if not isinstance(first, Mapping):
        return None
    stamp = first.get("stamp", first)
    if not isinstance(stamp, Mapping) or stamp.keys() != {"sec", "nanosec"}:
        return None
    return float(stamp["sec"]) + stamp["nanosec"] / _NANOS or None
