"""Watchdog: a process that kills all processes of the run if the launcher is killed.

It waits on a pipe, to which the launcher writes one byte before an orderly exit. EOF without that
byte means that the launcher was killed: then everything with its run id is killed.
Started as a script with `-I -S`: it must not depend on anything that can be broken or slow.
"""

from __future__ import annotations

import os
import signal
import sys
import time

GOODBYE = b"."
CLEAN_SCANS = 3  # a process that was forking during one scan shows in the next
SCAN_PAUSE_S = 0.01
TIMEOUT_S = 10.0  # a process in uninterruptible sleep cannot be killed


def kill_run(run_id: str) -> None:
    from launcher.engine.cleanup import sweep

    deadline = time.monotonic() + TIMEOUT_S
    clean = 0
    while clean < CLEAN_SCANS and time.monotonic() < deadline:
        found = sweep.signal_all(run_id, signal.SIGKILL)
        clean = 0 if sweep.signal_newest(run_id, signal.SIGKILL) or found else clean + 1
        time.sleep(SCAN_PAUSE_S)


def main() -> None:
    # The folder of `launcher` comes last: nothing in it may hide a module of Python's own.
    sys.path.append(os.path.abspath(__file__).rpartition("/launcher/engine/")[0])
    # Imported now: a watchdog that cannot work exits at once, and the launcher warns of it.
    import launcher.engine.cleanup.sweep  # noqa: F401

    os.chdir("/")  # so that it keeps no file system in use
    for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(signum, signal.SIG_IGN)
    if os.read(0, 1) != GOODBYE:
        kill_run(sys.argv[1])
    os._exit(0)  # faster than the interpreter's own exit, for which the launcher would wait


if __name__ == "__main__":
    main()
