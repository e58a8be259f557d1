"""The file of `bag record --static-topics-path`: topics that are recorded from the start."""

from __future__ import annotations

from launcher.bag.metadata import document_in
from launcher.base.errors import UsageError
from launcher.base.model.ros_names import full_name

_ROOT = "static_topics_and_types_list"


def read(path: str) -> dict[str, str]:
    """Topic -> type. UsageError with the place: nothing that was named may be left out silently."""
    document = document_in(path)
    entries = document.get(_ROOT) if isinstance(document, dict) else None
    if not isinstance(entries, list) or not entries:
        raise UsageError(f"{path} has no list '{_ROOT}'", hint=f"it begins with: {_ROOT}:")
    found: dict[str, str] = {}
    for number, entry in enumerate(entries, 1):
        topic, type_name = _entry(path, number, entry)
        if found.setdefault(topic, type_name) != type_name:
            raise UsageError(f"{path}: {topic} has two types, {found[topic]} and {type_name}")
    return found


def _entry(path: str, number: int, entry: object) -> tuple[str, str]:
    match entry:
        case [str(topic), str(type_name)] if topic and type_name.count("/") in (1, 2):
            package, _, rest = type_name.partition("/")
            return full_name(topic), type_name if "/" in rest else f"{package}/msg/{rest}"
    raise UsageError(
        f"{path}: {_ROOT}, entry {number}: {entry!r} is no topic with its type",
        hint="for example: - [/scan, sensor_msgs/msg/LaserScan]",
    )
