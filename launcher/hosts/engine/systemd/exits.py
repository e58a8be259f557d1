"""How a process ended, from what systemd reports of it."""

from __future__ import annotations

import errno
import signal
from collections.abc import Mapping

from launcher.base.model.events import Outcome
from launcher.hosts.file.order import Order
from launcher.run.processes.machine_events import SpawnError

_EXITED, _WAS_KILLED, _DUMPED = 1, 2, 3  # CLD_EXITED and so on
_EXIT_CPUAFFINITY = 215  # of systemd.exec(5): no such processor
_UNKNOWN = -9  # of a unit that is forgotten
TIMEOUT = "timeout"  # systemd has sent SIGKILL, since the process did not stop in time


def why_not_started(said: str, order: Order) -> SpawnError:
    """From what systemd-run has said, or the exit status of the unit if it has said nothing."""
    text = (said.strip().splitlines() or ["systemd-run failed"])[0]
    cpus = () if order.limits is None else order.limits.cpus or ()
    if cpus and text == f"ExecMainStatus={_EXIT_CPUAFFINITY}":
        return SpawnError(errno.EINVAL, f"cpus={','.join(map(str, cpus))}")
    return SpawnError(errno.EIO, text)


def outcome_of_record(result: str, code: str, status: str) -> Outcome:
    """`$SERVICE_RESULT`, `$EXIT_CODE` and `$EXIT_STATUS` of systemd."""
    if code == "exited":
        return Outcome(returncode=int(status) if status.isdigit() else 1)
    number = _signal_number(status)
    return Outcome(
        returncode=-number, core_dumped=code == "dumped", out_of_memory=result == "oom-kill"
    )


def _signal_number(name: str) -> int:
    """Of `KILL`, `RTMIN+3` or `37`."""
    if name.isdigit():
        return int(name)
    base, _, more = name.partition("+")
    try:
        return int(signal.Signals[f"SIG{base}"]) + int(more or 0)
    except (KeyError, ValueError):
        return int(signal.SIGKILL)


def outcome_of_unit(found: Mapping[str, str], stopped_by: int | None = None) -> Outcome:
    """The exit of a unit whose record is missing; the unit may be forgotten, too.

    One that was being stopped, by this signal, has then done what it was asked for.
    """
    code, status = int(found.get("ExecMainCode") or 0), int(found.get("ExecMainStatus") or 0)
    if code == _EXITED:
        return Outcome(returncode=status)
    if code in (_WAS_KILLED, _DUMPED):
        return Outcome(returncode=-status, core_dumped=code == _DUMPED)
    return Outcome(returncode=_UNKNOWN if stopped_by is None else -stopped_by)
