"""Processes that are hard to end: `python -S hostile.py KIND FOLDER` has a child of that kind.

It exits at SIGINT. Each process notes its pid as the name of an empty file in FOLDER.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
import time
from collections.abc import Callable

IGNORED = signal.valid_signals() - {signal.SIGKILL, signal.SIGSTOP, signal.SIGCHLD}
FLOOD = b"x" * 79 + b"\n"


def sleep() -> None:
    while True:
        time.sleep(1000)


def orphan() -> None:
    """Its parent exits, so that another process adopts it."""
    if os.fork():
        os._exit(0)


def ignore_signals() -> None:
    for signum in IGNORED:
        signal.signal(signum, signal.SIG_IGN)


def suspend() -> None:
    os.kill(os.getpid(), signal.SIGSTOP)


def end_main_thread() -> None:
    threading.Thread(target=sleep).start()
    ctypes.CDLL(None).pthread_exit(None)


def close_streams() -> None:
    for stream in range(3):
        os.close(stream)


def flood() -> None:
    while True:
        os.write(1, FLOOD * 100)


# What a child does before and after it notes its pid.
KINDS: dict[str, tuple[tuple[Callable[[], None], ...], tuple[Callable[[], None], ...]]] = {
    "plain": ((), ()),
    "setsid": ((os.setsid,), ()),
    "double fork": ((os.setsid, orphan), ()),
    "cleared environment": ((), ()),
    "all signals ignored": ((ignore_signals,), ()),
    "suspended": ((), (suspend,)),
    "ended main thread": ((), (end_main_thread,)),
    "closed streams": ((), (close_streams,)),
    "flood": ((), (flood,)),
    "daemon without environment, signals ignored": ((os.setsid, orphan, ignore_signals), ()),
}


def note(folder: str) -> None:
    open(f"{folder}/{os.getpid()}", "x").close()


def be_parent(kind: str, folder: str) -> None:
    signal.signal(signal.SIGINT, lambda *args: sys.exit(0))
    words = [sys.executable, "-S", os.path.abspath(__file__), kind, folder, "child"]
    is_bare = "environment" in kind
    os.posix_spawn(sys.executable, words, {} if is_bare else os.environ)
    note(folder)
    sleep()


def be_child(kind: str, folder: str) -> None:
    before, after = KINDS[kind]
    for step in before:
        step()
    note(folder)
    for step in after:
        step()
    sleep()


if __name__ == "__main__":
    (be_child if sys.argv[3:] else be_parent)(*sys.argv[1:3])
