"""A clock that differs from the machine's, for the processes of one host: libfaketime."""

from __future__ import annotations

from pathlib import Path


def library() -> Path | None:
    """The library that changes the clock; None if it is not installed."""
    return next(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"), None)


def variables(offset_s: float) -> dict[str, str]:
    """Variables with which a process sees another time; CLOCK_MONOTONIC changes, too."""
    if not offset_s:
        return {}
    return {
        "LD_PRELOAD": str(library()),
        "FAKETIME": f"{offset_s:+}",
        "FAKETIME_DONT_RESET": "1",  # children go on with the same offset
        "NO_FAKE_STAT": "1",
    }
