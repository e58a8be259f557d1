"""Find and signal the processes of a run, by the run id in their environment.

Process groups miss a daemon that made a session of its own; the environment is inherited by
everything. What clears its environment *and* leaves its session is not found.
It imports the standard library only: the watchdog runs this file without site-packages.
"""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator

RUN_ID_VARIABLE = "LAUNCHER_RUN_ID"
CHASE_ROUNDS = 200  # about 20 ms
CHASED = 4


def find(
    run_id: str, *, ignore: frozenset[int] = frozenset(), session: int | None = None
) -> list[int]:
    """Pids, other than ours and those in `ignore`, that carry this run id and are not zombies.

    With `session`, those in this session alone.
    """
    wanted = f"{RUN_ID_VARIABLE}={run_id}".encode()
    skipped = ignore | {os.getpid()}
    pids = (pid for pid in _pids() if session is None or _session_of(pid) == session)
    return [pid for pid in pids if pid not in skipped and _carries(pid, wanted)]


def signal_all(
    run_id: str,
    signum: int,
    *,
    ignore: frozenset[int] = frozenset(),
    session: int | None = None,
) -> list[int]:
    """Signal each of them; the pids that were signalled.

    A pidfd is opened first and then the environment read again, so that a pid which was given to
    another process in between is left alone.
    """
    found = find(run_id, ignore=ignore, session=session)
    return [pid for pid in found if _signal(pid, signum, run_id)]


def chase(
    run_id: str,
    signum: int,
    *,
    ignore: frozenset[int] = frozenset(),
    rounds: int = CHASE_ROUNDS,
) -> bool:
    """Signal the youngest processes that carry the id, again and again; whether there was one.

    One that forks and ends all the time is gone before `find` comes to it. Signal 0 sends nothing.
    """
    wanted = f"{RUN_ID_VARIABLE}={run_id}".encode()
    has_seen = False
    for _ in range(rounds):
        last = _last_pid()
        for pid in range(last, max(1, last - CHASED), -1):
            if pid not in ignore and _carries(pid, wanted):
                has_seen = True
                _signal(pid, signum, run_id)
    return has_seen


def _last_pid() -> int:
    with open("/proc/loadavg", "rb") as file:
        return int(file.read().split()[-1])


def _signal(pid: int, signum: int, run_id: str) -> bool:
    try:
        pidfd = os.pidfd_open(pid)
    except OSError:
        return False
    try:
        if _carries(pid, f"{RUN_ID_VARIABLE}={run_id}".encode()):
            with contextlib.suppress(OSError):
                signal.pidfd_send_signal(pidfd, signum)
                return True
        return False
    finally:
        os.close(pidfd)


def _pids() -> Iterator[int]:
    """The newest first: one that forks and ends all the time must be read before it is gone."""
    return iter(sorted((int(name) for name in os.listdir("/proc") if name.isdigit()), reverse=True))


def _session_of(pid: int) -> int:
    try:
        return os.getsid(pid)
    except OSError:
        return -1  # it has just ended


def _carries(pid: int, wanted: bytes) -> bool:
    # The environment of a zombie and of a kernel thread is empty, so neither is ever found.
    try:
        with open(f"/proc/{pid}/environ", "rb") as file:
            return wanted in file.read().split(b"\0")
    except OSError:
        return False
