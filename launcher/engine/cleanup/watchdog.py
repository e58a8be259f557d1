"""Watchdog: a process that ends all processes of the run if the launcher is killed.

It waits on a pipe. The launcher writes one byte there when it ends in order; the end of the pipe
without that byte means that the launcher died, and everything that carries its run id is killed.
Started as a script with `-I -S`: it must not depend on anything that can be broken or slow.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from types import ModuleType

GOODBYE = b"."
CLEAN_SCANS = 3  # a process that was forking during one scan shows in the next
SCAN_PAUSE_S = 0.01
PATIENCE_S = 10.0  # a process in uninterruptible sleep cannot be killed


def end_run(sweep: ModuleType, run_id: str) -> None:
    deadline = time.monotonic() + PATIENCE_S
    clean = 0
    while clean < CLEAN_SCANS and time.monotonic() < deadline:
        found = sweep.signal_all(run_id, signal.SIGKILL)
        clean = 0 if sweep.chase(run_id, signal.SIGKILL) or found else clean + 1
        time.sleep(SCAN_PAUSE_S)


def main() -> None:
    # Beside this file, which runs as a script; our other modules must not hide Python's own.
    # Imported now: a watchdog that cannot work ends at once, and the launcher warns of it.
    sys.path.append(os.path.dirname(os.path.abspath(__file__)))
    import sweep  # type: ignore[import-not-found]

    os.chdir("/")  # so that it keeps no file system in use
    for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(signum, signal.SIG_IGN)
    if os.read(0, 1) != GOODBYE:
        end_run(sweep, sys.argv[1])
    os._exit(0)  # the interpreter's own end takes longer, and the launcher waits for ours


if __name__ == "__main__":
    main()
