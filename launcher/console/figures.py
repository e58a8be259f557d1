"""Figures: numbers as people read them, short enough for a status bar."""

from __future__ import annotations

_UNITS = "kMGT"


def memory(size_bytes: float) -> str:
    """`58M`, `1.2G`."""
    unit, size = "", float(size_bytes)
    for larger in _UNITS:
        if size < 999.5:
            break
        unit, size = larger, size / 1000
    return f"{size:.1f}{unit}" if unit in ("G", "T") else f"{size:.0f}{unit}"


def cpu(percent: float) -> str:
    """`12%`."""
    return f"{percent:.0f}%"


def duration(seconds: float) -> str:
    """`12 s`, `3:05`, `2:03:05`, `4 d 02:03`."""
    whole = int(seconds)
    if whole < 60:
        return f"{whole} s"
    minutes, second = divmod(whole, 60)
    hours, minute = divmod(minutes, 60)
    days, hour = divmod(hours, 24)
    if days:
        return f"{days} d {hour:02}:{minute:02}"
    return f"{hour}:{minute:02}:{second:02}" if hour else f"{minute}:{second:02}"
