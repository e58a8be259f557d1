"""The state of a unit, from the properties that systemd shows of it."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.run.processes.machine_events import ProcessState


def is_running(found: Mapping[str, str]) -> bool:
    """Whether its process runs."""
    return found.get("ActiveState") == "active" and found.get("MainPID", "0") != "0"


def was_stopped(found: Mapping[str, str]) -> bool:
    """Whether somebody has stopped a unit that waited for its restart; else it has failed."""
    return found.get("ActiveState") == "inactive" and found.get("Result") != "exec-condition"


def state_of(found: Mapping[str, str]) -> ProcessState:
    """What a machine that takes the unit as it is begins with."""
    if is_running(found):
        return ProcessState.RUNNING
    if found.get("SubState") == "auto-restart":
        return ProcessState.BACKOFF
    return ProcessState.FATAL if found.get("ActiveState") == "failed" else ProcessState.EXITED
