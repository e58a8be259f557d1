"""Find and signal the processes of a run, by the run id in their environment.

Process groups miss a daemon that made a new session; the environment is inherited by
everything. A process that clears its environment *and* leaves its session is found only among
`kin`: pid -> start of processes that are known to belong to the run.
The watchdog uses this: its rules for imports apply.
"""

from __future__ import annotations

import os

from launcher.posix import proc
from launcher.posix.cleanup import RUN_ID_VARIABLE

TYPE_CHECKING = False
if TYPE_CHECKING:
    import signal
    from collections.abc import Mapping
else:
    import _signal as signal  # see `watchdog`

NEWEST_ROUNDS = 200  # about 20 ms
NEWEST = 4  # processes per round


_NONE: Mapping[int, int] = {}


def find(
    run_id: str,
    *,
    ignore: frozenset[int] = frozenset(),
    session: int | None = None,
    kin: Mapping[int, int] = _NONE,
) -> tuple[list[int], list[int]]:
    """Pids with this run id or in `kin`, and pids whose exec is not complete, which may have it.

    Newest first. Zombies, we ourselves and those in `ignore` are left out. With `session`, only
    those in this session.
    """
    found: list[int] = []
    in_exec: list[int] = []
    skipped = ignore | {os.getpid()}
    entry = _entry(run_id)
    # A process that forks and exits in a loop must be read before it is gone.
    for pid in sorted(proc.pids(), reverse=True):
        if pid in skipped or (session is not None and _session_of(pid) != session):
            continue
        environment = proc.environment(pid)
        if entry in environment or _is_kin(pid, kin):
            found.append(pid)
        elif environment == [b""] and proc.was_in_exec(pid):
            in_exec.append(pid)
    return found, in_exec


def signal_all(
    run_id: str,
    signum: int,
    *,
    ignore: frozenset[int] = frozenset(),
    session: int | None = None,
    kin: Mapping[int, int] = _NONE,
) -> bool:
    """Signal the processes that `find` finds; whether there was one, or may be one in exec.

    A pidfd is opened first and then the evidence read again, so that a pid that was reused in
    between is left alone.
    """
    found, in_exec = find(run_id, ignore=ignore, session=session, kin=kin)
    for pid in found:
        _signal(pid, signum, run_id, kin)
    return bool(found or in_exec)


def signal_newest(
    run_id: str,
    signum: int,
    *,
    ignore: frozenset[int] = frozenset(),
    rounds: int = NEWEST_ROUNDS,
) -> bool:
    """Signal the newest processes of the run, repeatedly; whether there was one.

    A process that forks and exits in a loop is gone before `find` reads it. Signal 0 sends nothing.
    """
    has_seen = False
    for _ in range(rounds):
        last = int(proc.read(".", "loadavg").split()[-1])
        for pid in range(last, max(1, last - NEWEST), -1):
            if pid not in ignore and _has_run_id(pid, run_id):
                has_seen = True
                _signal(pid, signum, run_id)
    return has_seen


def _signal(pid: int, signum: int, run_id: str, kin: Mapping[int, int] = _NONE) -> None:
    try:
        pidfd = os.pidfd_open(pid)
    except OSError:
        return
    try:
        if _has_run_id(pid, run_id) or _is_kin(pid, kin):
            signal.pidfd_send_signal(pidfd, signum)
    except OSError:
        return
    finally:
        os.close(pidfd)


def _session_of(pid: int) -> int:
    try:
        return os.getsid(pid)
    except OSError:
        return -1  # it has just exited


def _has_run_id(pid: int, run_id: str) -> bool:
    """False for zombies and kernel threads, whose environment is empty."""
    return _entry(run_id) in proc.environment(pid)


def _is_kin(pid: int, kin: Mapping[int, int]) -> bool:
    """False if the pid was reused."""
    return pid in kin and proc.start_ticks(pid) == kin[pid]


def _entry(run_id: str) -> bytes:
    return f"{RUN_ID_VARIABLE}={run_id}".encode()
