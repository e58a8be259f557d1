"""Lets a node write on request what its threads are doing, for `stack` without py-spy.

A thread waits for a byte in a pipe, which the launcher opens in /proc, and writes the stacks to a
file in memory. It needs the GIL for that, as any Python code. `faulthandler`, which does not, was
tried first: on a signal it reads frames that the interrupted thread is just changing, which crashed
busy programs once in 50 to 900 dumps (3.10, 3.12, 3.13).
"""

from __future__ import annotations

import fcntl
import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    import signal
    from collections.abc import Iterator
    from types import FrameType
else:
    import _signal as signal

FILE = "launcher-stacks"  # in memory; the pipe has the descriptor after it
_LOWEST_FD = 250  # above those that a program expects to get


def offer() -> None:
    """Answer from now on; to be called in the process of a node. Does nothing if it cannot."""
    try:
        requests, file = _descriptors()
    except OSError:  # a small limit
        return
    import _thread

    # The thread must not take signals for which the program waits by `sigwait`.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
    try:
        _thread.start_new_thread(_answer, (requests, file))
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _descriptors() -> tuple[int, int]:
    """A pipe for both directions, and the file; a program that is executed gets neither."""
    file = os.memfd_create(FILE, os.MFD_CLOEXEC)
    theirs, ours = os.pipe()
    both = os.open(f"/proc/self/fd/{theirs}", os.O_RDWR | os.O_CLOEXEC)
    low = (file, both)
    try:
        high_file, high_pipe = (fcntl.fcntl(fd, fcntl.F_DUPFD_CLOEXEC, _LOWEST_FD) for fd in low)
    finally:
        for fd in (*low, theirs, ours):
            os.close(fd)
    fcntl.fcntl(high_file, fcntl.F_SETFL, os.O_APPEND)
    return high_pipe, high_file


def _answer(requests: int, file: int) -> None:
    try:
        while os.read(requests, 1):
            os.write(file, _text().encode(errors="backslashreplace"))
    except OSError:  # the program has closed them
        return


def _text() -> str:
    """`pid N`, per thread `thread TID NAME` and a line for each of its frames, and `end N`."""
    import _thread

    threading = sys.modules.get("threading")
    known = getattr(threading, "_active", {})
    pid = os.getpid()
    lines = [f"pid {pid}"]
    for ident, frame in sys._current_frames().items():
        if ident != _thread.get_ident():
            thread = known.get(ident)
            tid = getattr(thread, "native_id", None) or 0
            lines += [f"thread {tid} {getattr(thread, 'name', '-')}", *_frames(frame)]
    return "\n".join([*lines, f"end {pid}\n"])


def _frames(top: FrameType) -> Iterator[str]:
    """`LINE FUNCTION NUL FILE`, the innermost call first."""
    frame: FrameType | None = top
    while frame is not None:
        code = frame.f_code
        yield f"{frame.f_lineno or 0} {code.co_name}\0{code.co_filename}"
        frame = frame.f_back
