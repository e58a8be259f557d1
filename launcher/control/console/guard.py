"""Starts a verb for a process, and ends it with that: `guard.py LIFELINE COMMAND ...`.

LIFELINE is a pipe from that process, such as the console. A byte in it is a signal for the verb and
what it has started; its end means that the process has ended, by whatever signal, or does not need
the verb any more. The exit code is that of the verb, 128 and the number of a signal if that has
ended it.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time

GUARD = os.path.abspath(__file__)
PATIENCE_S = 3.0  # for an orderly end, after the other process has gone


def guarded(words: list[str], lifeline: int) -> list[str]:
    """The command line of a verb of the launcher behind a guard that inherits `lifeline`."""
    verb = [sys.executable, "-m", "launcher", *words]
    return [sys.executable, "-I", "-S", GUARD, str(lifeline), *verb]


def main(words: list[str]) -> int:
    lifeline, command = int(words[0]), words[1:]
    os.set_inheritable(lifeline, False)
    # The other process may ignore signals, and what it starts would do so, too.
    every = signal.valid_signals()
    pid = os.posix_spawn(
        command[0], command, os.environ, setsid=True, setsigdef=every, setsigmask=()
    )
    _watch(lifeline, pid)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


def _watch(lifeline: int, pid: int) -> None:
    """Pass signals on until the verb has ended."""
    pidfd = os.pidfd_open(pid)
    poll = select.poll()
    poll.register(pidfd, select.POLLIN)
    poll.register(lifeline, select.POLLIN)
    deadline: float | None = None
    while True:
        left_ms = None if deadline is None else max(0.0, deadline - time.monotonic()) * 1000
        ready = [fd for fd, _ in poll.poll(left_ms)]
        if pidfd in ready:
            return
        if lifeline in ready:
            numbers = os.read(lifeline, 64)
            for number in numbers or [signal.SIGINT]:
                _signal(pid, number)
            if not numbers:
                poll.unregister(lifeline)
                deadline = time.monotonic() + PATIENCE_S
        elif deadline is not None:
            _signal(pid, signal.SIGKILL)
            deadline = None


def _signal(group: int, number: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, number)


if __name__ == "__main__":
    code = main(sys.argv[1:])
    sys.exit(code if code >= 0 else 128 - code)
