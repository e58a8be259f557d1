"""Limits the destruction of nodes, which may hang in Fast DDS.

It may loop for ever with the GIL held if another participant leaves just then
(eProsima/Fast-DDS#6513), or wait for ever for a lock, which another thread has, or an owner in
shared memory that has died. Only a signal's default action ends such a process: no thread and no
Python handler runs.
"""

from __future__ import annotations

import contextlib
import signal
import sys
from collections.abc import Iterator

CPU_S = 2.0  # the destruction of a node takes 0.05 s
WALL_S = 8.0  # a process is killed 10 s after SIGINT


@contextlib.contextmanager
def limited_clean_up(*, cpu_s: float = CPU_S, wall_s: float = WALL_S) -> Iterator[None]:
    """End the process by SIGPROF or SIGALRM if the block hangs; output is flushed before."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):  # closed, or without a reader
            stream.flush()
    limits = ((signal.ITIMER_PROF, cpu_s), (signal.ITIMER_REAL, wall_s))
    before = [(which, signal.setitimer(which, limit_s)) for which, limit_s in limits]
    try:
        yield
    finally:
        for which, timer in before:
            signal.setitimer(which, *timer)
