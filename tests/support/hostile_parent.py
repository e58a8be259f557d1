"""Starts programs as parents do that ignore or block signals, which is inherited."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterable, Sequence

from launcher.posix import dispositions

ALL = sorted(dispositions.EVERY - {signal.SIGKILL, signal.SIGSTOP})
_BECOME = """
import os, signal, sys
ignored, blocked = (map(int, filter(None, text.split(","))) for text in sys.argv[1:3])
for number in (signal.SIGPIPE, signal.SIGXFSZ):
    signal.signal(number, signal.SIG_DFL)
for number in ignored:
    signal.signal(number, signal.SIG_IGN)
signal.pthread_sigmask(signal.SIG_BLOCK, blocked)
os.execvp(sys.argv[3], sys.argv[3:])
"""


def with_signals(
    command: Sequence[str], *, ignored: Iterable[int] = ALL, blocked: Iterable[int] = ALL
) -> list[str]:
    """A command that becomes this one, with these signals ignored and blocked."""
    numbers = (",".join(map(str, map(int, some))) for some in (ignored, blocked))
    return [sys.executable, "-c", _BECOME, *numbers, *command]
