"""Pseudo-terminals for the output of processes, and their size."""

from __future__ import annotations

import fcntl
import os
import struct
import termios


def open_pair() -> tuple[int, int]:
    """(our end, the child's end), without output processing: lines end in \\n, not in \\r\\n.

    OSError.
    """
    ours, theirs = os.openpty()
    attributes = termios.tcgetattr(theirs)
    attributes[1] &= ~termios.OPOST
    termios.tcsetattr(theirs, termios.TCSANOW, attributes)
    return ours, theirs


def set_size(fd: int, size: tuple[int, int]) -> None:
    """`size` is (columns, rows). OSError."""
    columns, rows = size
    fcntl.ioctl(fd, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))


def size_beside(taken: int) -> tuple[int, int]:
    """(columns, rows) for a child's pseudo-terminal: ours, less the prefix of `taken` columns."""
    for fd in (1, 0):  # with a console, only standard input is the terminal
        try:
            columns, rows = os.get_terminal_size(fd)
        except OSError:
            continue
        return max(20, columns - taken), max(2, rows)
    return 80, 24
