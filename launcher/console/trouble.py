"""Trouble: which processes a person should look at, however many others there are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_STATES = ("FATAL", "BACKOFF", "STOPPING", "STOPPED")


def is_in_trouble(process: Mapping[str, Any]) -> bool:
    """Whether it is down, on its way there, paused, or has died."""
    state = process["state"]
    last = process.get("last_exit") or {}
    died = state == "EXITED" and last.get("returncode") not in (0, None) and not last.get("asked")
    return died or state in _STATES or bool(process.get("paused"))
