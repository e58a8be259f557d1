"""Lines: what the items of streams are for people."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any


def log_line(item: Mapping[str, Any]) -> str:
    """An item of `logs`."""
    if "dropped" in item:
        return f"({item['dropped']} lines were not read in time)"
    name = item["process"]
    return str(item["text"]) if name is None else f"[{name}] {item['text']}"


def event_line(item: Mapping[str, Any]) -> str:
    """An item of `events`."""
    if "dropped" in item:
        return f"({item['dropped']} events were not read in time)"
    details = dict(item)
    clock = time.strftime("%H:%M:%S", time.localtime(details.pop("wall_s")))
    details.pop("monotonic_s")
    event, process = details.pop("event"), details.pop("process", None)
    if event == "resources":
        details = {name: _used(sample) for name, sample in details["processes"].items()}
    words = [clock, event, *([process] if process else [])]
    return " ".join([*words, *(f"{key}={value}" for key, value in details.items())])


def _used(sample: Mapping[str, Any]) -> str:
    cpu = "-" if sample["cpu_percent"] is None else f"{sample['cpu_percent']:.0f}%"
    return f"{cpu},{sample['rss_bytes'] / 1e6:.0f}MB"


def not_shown(lines: int) -> str:
    """How much of a process is held back from the screen."""
    return "1 line not shown" if lines == 1 else f"{lines} lines not shown"
