"""Guard: a process that stops the launcher when we are killed before we could.

It waits on a pipe. We write one byte there when all is over; the end of the pipe without that
byte means that we died. Started as a script with `-I -S`: nothing that it needs can be broken.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys

GOODBYE = b"."
PATIENCE_S = 30.0  # an orderly stop with all its escalations
GOODBYE_S = 2.0


class Guard:
    """Our end of it, for a launcher that runs; `close()` when the launcher has ended."""

    def __init__(self, launcher_pid: int) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", os.path.abspath(__file__), str(launcher_pid)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd="/",
            start_new_session=True,
            bufsize=0,
        )

    def close(self) -> None:
        """All is over; more than once does no harm."""
        assert self._process.stdin is not None
        if self._process.stdin.closed:
            return
        try:
            self._process.stdin.write(GOODBYE)
        except BrokenPipeError:
            pass  # somebody killed it
        finally:
            self._process.stdin.close()
        try:
            self._process.wait(GOODBYE_S)
        except subprocess.TimeoutExpired:  # somebody has stopped it
            self._process.kill()
            self._process.wait()


def _end(launcher: int) -> None:
    """As Ctrl-C, then with force; what the launcher had started, its own watchdog ends."""
    signal.pidfd_send_signal(launcher, signal.SIGINT)
    ended, _, _ = select.select([launcher], [], [], PATIENCE_S)
    if not ended:
        signal.pidfd_send_signal(launcher, signal.SIGKILL)


def main() -> None:
    """Wait for the end of standard input."""
    for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(signum, signal.SIG_IGN)
    try:
        launcher = os.pidfd_open(int(sys.argv[1]))
    except ProcessLookupError:
        return  # it was over before we were up
    if os.read(0, 1) != GOODBYE:
        _end(launcher)


if __name__ == "__main__":
    main()
