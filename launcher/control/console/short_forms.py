"""Short forms for the status bar and tables: cut texts, sizes, durations."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich.cells import cell_len, set_cell_size

from launcher.base.program import program

MARK = "…"
_UNITS = "kMGT"
_TROUBLE = ("FATAL", "BACKOFF", "STOPPING", "STOPPED")


def end_cut(text: str, columns: int) -> str:
    """The text, cut at its end."""
    return text if cell_len(text) <= columns else set_cell_size(text, max(0, columns - 1)) + MARK


def middle_cut(text: str, columns: int) -> str:
    """The text, cut in its middle: names that begin alike stay different."""
    if cell_len(text) <= columns:
        return text
    start = len(text)
    while start > 0 and cell_len(text[start - 1 :]) <= (columns - 1) // 2:
        start -= 1
    end = text[start:]
    return set_cell_size(text, max(0, columns - 1 - cell_len(end))).rstrip() + MARK + end


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


def ending(process: Mapping[str, Any]) -> str:
    """How it ended last: `finished`, `exit 4`, `SIGSEGV`, `not started`; empty while unknown."""
    last = process.get("last_exit")
    if not last:
        return ""
    code = last.get("returncode")
    if code is None:
        return "not started"
    if code < 0:
        return str(last["text"]).partition(",")[0]  # without `core dumped`
    return f"exit {code}" if code else "finished"


def has_died(process: Mapping[str, Any]) -> bool:
    """Whether it has failed: by itself, or by crashing when it was stopped."""
    last = process.get("last_exit") or {}
    is_bad = last.get("returncode") not in (0, None) and not last.get("asked")
    return is_bad and process["state"] in ("EXITED", "STOPPED")


def is_in_trouble(process: Mapping[str, Any]) -> bool:
    """Whether it needs attention: it has failed, is stopped, paused, unreachable, or silent."""
    state = process["state"]
    is_silent = process.get("unreachable_s") is not None or bool(process.get("not_responding_s"))
    return has_died(process) or state in _TROUBLE or bool(process.get("paused")) or is_silent


def killed_text(processes: Sequence[Mapping[str, Any]]) -> str:
    """Whether the processes of a launcher that was killed run on or are stopped."""
    elsewhere = [one for one in processes if one.get("host", "local") != "local" and one["pid"]]
    running = _hosts(one for one in elsewhere if one["stop_after_s"] is None)
    stopping = _hosts(one for one in elsewhere if one["stop_after_s"] is not None)
    here = " on this machine" if elsewhere else ""
    text = f"the launcher was killed; its watchdog kills its processes{here}"
    if running:
        back = f" ({program()} attach)" if any(one["unit"] for one in elsewhere) else ""
        text += f"; those on {running} run on{back}"
    return f"{text}; those on {stopping} are stopped there" if stopping else text


def _hosts(processes: Iterable[Mapping[str, Any]]) -> str:
    return ", ".join(sorted({one["host"] for one in processes}))
