"""Numbers of bags as words, in the way of rosbag2 where it has one."""

from __future__ import annotations

import time

_UNITS = ("B", "KiB", "MiB", "GiB", "TiB")


def size(count: float) -> str:
    """`1.5 MiB`, as `ros2 bag info` prints sizes."""
    for unit in _UNITS:
        if count < 1024 or unit == _UNITS[-1]:
            break
        count /= 1024
    return f"{count:.0f} {unit}" if unit == "B" else f"{count:.1f} {unit}"


def date(ns: int) -> str:
    """`Nov 27 2026 14:03:05.123456789 (1795788185.123456789)`, in local time."""
    seconds, rest = divmod(ns, 10**9)
    local = time.strftime("%b %e %Y %H:%M:%S", time.localtime(seconds))
    return f"{local}.{rest:09} ({seconds}.{rest:09})"


def duration(ns: int) -> str:
    """`12.345678901s`."""
    return f"{ns // 10**9}.{ns % 10**9:09}s"


def clock(seconds: float) -> str:
    """`1:02:03.4`, or `2:03.4` below an hour."""
    tenths = round(seconds * 10)
    minutes, tenths = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    text = f"{minutes:02}:{tenths // 10:02}.{tenths % 10}" if hours else ""
    return f"{hours}:{text}" if hours else f"{minutes}:{tenths // 10:02}.{tenths % 10}"
