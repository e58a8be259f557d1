"""Polling for a condition."""

from __future__ import annotations

import time
from collections.abc import Callable

LOOK_S = 0.02


def wait_until(fact: Callable[[], object], what: str, timeout_s: float = 60.0) -> None:
    """Poll until the fact holds; AssertionError at the deadline."""
    deadline = time.monotonic() + timeout_s
    while not fact():
        assert time.monotonic() < deadline, f"not within {timeout_s} s: {what}"
        time.sleep(LOOK_S)
