"""Watchdog: a process that kills all processes of the run if the launcher is killed.

It reads messages from a pipe, one a line; EOF without a goodbye means that the launcher was killed.
Started as a script with `-I -S`: it must not depend on anything that can be broken or slow. It has
no site-packages, and imports little: `signal`, `contextlib` and `collections.abc` would make the
memory that it takes larger by half.
"""

from __future__ import annotations

import os
import select
import sys

GOODBYE = b"goodbye"
LEAVE = b"leave"  # the launcher is about to stop everything
KEEP = b"keep"  # the pid of a process follows that must not be killed
MESSAGE_BYTES = 4096


def main() -> None:
    # The folder of `launcher` comes last: nothing in it may hide a module of Python's own.
    sys.path.append(os.path.abspath(__file__).rpartition("/launcher/posix/")[0])
    # Imported now: a watchdog that cannot work exits at once, and the launcher warns of it.
    from launcher.posix import dispositions
    from launcher.posix.cleanup.run_watch import RunWatch

    os.chdir("/")  # so that it keeps no file system in use
    dispositions.ignore()
    run_id, launcher, kind, *before = sys.argv[1:]
    watch = RunWatch(run_id, int(launcher), kind, frozenset(map(int, before)))
    poll = select.poll()
    poll.register(0, select.POLLIN)
    while True:
        pause_s = watch.pause_s
        if not poll.poll(None if pause_s is None else pause_s * 1000):
            watch.note()
            continue
        text = os.read(0, MESSAGE_BYTES)
        for message in text.splitlines():  # shorter than PIPE_BUF: never in two pieces
            word, _, pid = message.partition(b" ")
            if word == KEEP:
                watch.keep(int(pid))
            elif word == LEAVE:
                watch.release_launcher()
        if not text or GOODBYE in text:
            break
    if text:
        watch.close()
    else:
        watch.kill()
    os._exit(0)  # faster than the interpreter's own exit, for which the launcher would wait


if __name__ == "__main__":
    main()
