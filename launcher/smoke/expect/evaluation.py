"""The process that evaluates conditions: `python -m launcher.smoke.expect.evaluation`.

Its standard input has pickled batches of conditions and pickled contents; it prints a line of JSON
for each: a list of `[holds, why not]`. Nothing in the process itself can end `sum(range(10**12))`:
the kernel ends it when a batch takes too long, and its parent learns why from the exit code.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import pickle
import resource
import signal
import sys
from collections.abc import Iterable, Sequence
from typing import Protocol

from launcher.base import strict_json
from launcher.posix import dispositions

CPU_S = 1.0  # for a batch, which needs some milliseconds
CPU_MORE_S = 0.1  # for each content; an image of a megabyte takes half of it
MEMORY_BYTES = 512 * 1024**2
OUT_OF_MEMORY = 3  # exit code
MAX_REASON = 500  # characters


class EvaluatedCondition(Protocol):
    @property
    def text(self) -> str: ...

    def holds(self, content: object) -> tuple[bool, str | None]: ...


def main() -> int:
    """Answer batches until standard input is closed."""
    _end_with_parent()
    dispositions.ignore()  # those of the terminal or a CI server: the parent decides
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    _limit(resource.RLIMIT_AS, MEMORY_BYTES)
    try:
        with contextlib.suppress(EOFError, BrokenPipeError):
            while True:
                conditions, contents = pickle.load(sys.stdin.buffer)
                print(strict_json.packed(_limited(conditions, contents)), flush=True)
    except MemoryError:
        os._exit(OUT_OF_MEMORY)
    return 0


def _limit(which: int, most: int) -> None:
    _, hard = resource.getrlimit(which)
    resource.setrlimit(which, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _end_with_parent() -> None:
    """SIGIO ends us when the parent closes its end of standard error, which it never reads."""
    fcntl.fcntl(2, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(2, fcntl.F_SETFL, fcntl.fcntl(2, fcntl.F_GETFL) | os.O_ASYNC)


def _limited(
    conditions: Iterable[EvaluatedCondition], contents: Sequence[bytes]
) -> list[tuple[bool, str | None]]:
    signal.setitimer(signal.ITIMER_PROF, CPU_S + CPU_MORE_S * len(contents))
    try:
        return [judged(conditions, pickle.loads(content)) for content in contents]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def judged(conditions: Iterable[EvaluatedCondition], content: object) -> tuple[bool, str | None]:
    """Whether all hold, and why not."""
    for condition in conditions:
        fits, why = condition.holds(content)
        if not fits:
            return False, why and why[:MAX_REASON]
    return True, None


if __name__ == "__main__":
    sys.exit(main())
