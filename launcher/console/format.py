"""Cutting: texts that are too long for their place, with a mark where something is missing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.cells import cell_len, set_cell_size

MARK = "…"


def end_cut(text: str, columns: int) -> str:
    """The beginning of the text."""
    return text if cell_len(text) <= columns else set_cell_size(text, max(0, columns - 1)) + MARK


def middle_cut(text: str, columns: int) -> str:
    """Its beginning and its end, which tells names that begin alike apart."""
    if cell_len(text) <= columns:
        return text
    end = _end(text, (columns - 1) // 2)
    return set_cell_size(text, max(0, columns - 1 - cell_len(end))).rstrip() + MARK + end


def _end(text: str, columns: int) -> str:
    """As much of the end of the text as has room."""
    start = len(text)
    while start > 0 and cell_len(text[start - 1 :]) <= columns:
        start -= 1
    return text[start:]


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


_STATES = ("FATAL", "BACKOFF", "STOPPING", "STOPPED")


def is_in_trouble(process: Mapping[str, Any]) -> bool:
    """Whether it is down, on its way there, paused, or has died."""
    state = process["state"]
    last = process.get("last_exit") or {}
    died = state == "EXITED" and last.get("returncode") not in (0, None) and not last.get("asked")
    return died or state in _STATES or bool(process.get("paused"))
