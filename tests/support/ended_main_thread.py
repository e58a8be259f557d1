"""A process whose main thread has ended, as after pthread_exit() in main: another thread lives on.

Prints `ready` when /proc shows it as a zombie. SIGINT has no effect, SIGTERM ends it. Importable
for `started`, and a program: `python tests/support/ended_main_thread.py`.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping

PROGRAM = os.path.abspath(__file__)
_SYS_EXIT = 60  # ends the calling thread, where exit_group() ends all


@contextlib.contextmanager
def started(env: Mapping[str, str] | None = None) -> Iterator[int]:
    """Its pid; a child of this process, which is killed in the end."""
    command = [sys.executable, PROGRAM]
    with subprocess.Popen(command, env=env, stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"ready\n"
            yield process.pid
        finally:
            process.kill()


def _live_on() -> None:
    while _state() != "Z":
        time.sleep(0.01)
    print("ready", flush=True)
    time.sleep(1000)


def _state() -> str:
    with open(f"/proc/{os.getpid()}/stat", encoding="ascii") as file:
        return file.read().rpartition(")")[2].split()[0]


if __name__ == "__main__":
    threading.Thread(target=_live_on).start()
    ctypes.CDLL(None).syscall(_SYS_EXIT, 0)
