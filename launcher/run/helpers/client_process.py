"""Starts helper processes that are clients of the run: the ROS bridge, the flight recorder, the
watcher of faults, the server of the page.

They are not processes of the run: they do not affect the exit code.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Callable, Sequence

from launcher.base.text import how_it_ended
from launcher.posix.reactor import Timer
from launcher.run.helpers.json_lines import own_end
from launcher.run.helpers.popen import last_line, start_module, wait_or_kill

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.run import Run

MAX_STARTS = 3  # then the run continues without one
RESTART_DELAY_S = 1.0
_READ_BYTES = 64 * 1024


class ClientProcess:
    """`python -m` with these words, restarted if it exits. `name` is what it is in messages.

    `without` says what a run lacks that cannot start it. It gets `goodbye_s` for its exit at the
    end of its standard input. Its shared memory is freed if it is killed. It
    outlives a killed launcher, to exit by itself. `on_line` is called with each line of its
    output; without, it has none. When it has died, `on_exit` is called with whether it is
    restarted. `greeting` is the first line of its input.
    """

    def __init__(
        self,
        run: Run,
        words: Sequence[str],
        *,
        name: str,
        without: str,
        goodbye_s: float,
        on_line: Callable[[bytes], None] | None = None,
        on_exit: Callable[[bool], object] = lambda is_restarted: None,
    ) -> None:
        self._run = run
        self._reactor = run.reactor
        self._words = words
        self._name = name
        self._without = without
        self._goodbye_s = goodbye_s
        self._on_line = on_line
        self._on_exit = on_exit
        self.greeting: bytes | None = None
        self._output = b""
        self._env = own_end(run.env)
        self._warn = run.log.warn
        self._started = 0
        self._started_s = 0.0
        self._process: subprocess.Popen[bytes] | None = None
        self._pidfd = self._errors = -1
        self._timer: Timer | None = None

    @property
    def pid(self) -> int | None:
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        self._timer = None
        self._started += 1
        self._started_s = time.time()
        self._errors = os.memfd_create("helper-errors", os.MFD_CLOEXEC)
        try:
            self._process = start_module(
                self._words,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL if self._on_line is None else subprocess.PIPE,
                stderr=self._errors,
                env=self._env,
            )
        except OSError as error:
            os.close(self._errors)
            self._warn(f"{self._without}: cannot start {self._name}: {error.strerror}")
            self._on_exit(False)
            return
        self._run.adopt_helper(self._process.pid)
        self._pidfd = os.pidfd_open(self._process.pid)
        self._reactor.add_reader(self._pidfd, self._exited)
        if self._process.stdout is not None:
            self._reactor.add_reader(self._process.stdout.fileno(), self._readable)
        if self.greeting is not None:
            self.send(self.greeting)

    def give_up(self) -> None:
        """Do not restart it when it exits."""
        self._started = MAX_STARTS

    def send(self, line: bytes) -> bool:
        """Write a line to its standard input; False if it is not running."""
        if self._process is None or self._process.stdin is None:
            return False
        try:
            self._process.stdin.write(line + b"\n")
            self._process.stdin.flush()
        except OSError:
            return False
        return True

    def _readable(self) -> None:
        assert self._process is not None and self._process.stdout is not None
        data = os.read(self._process.stdout.fileno(), _READ_BYTES)
        if not data:
            self._reactor.remove(self._process.stdout.fileno())
        self._take(data)

    def _take(self, data: bytes) -> None:
        *lines, self._output = (self._output + data).split(b"\n")
        for line in lines:
            if self._on_line is not None:
                self._on_line(line)

    def _exited(self) -> None:
        assert self._process is not None
        code = self._process.wait()
        if code:
            self._run.housekeeper.ledger.died(code, self._started_s)
        line = last_line(self._errors) if code > 0 else ""  # a signal comes from elsewhere
        reason = f": {line}" if line else ""
        self._release()
        is_restarted = self._started < MAX_STARTS
        what = "restarting it" if is_restarted else "the run continues without it"
        self._warn(f"{self._name} died ({how_it_ended(code)}){reason}; {what}")
        if is_restarted:
            self._timer = self._reactor.call_later(RESTART_DELAY_S, self.start)
        self._on_exit(is_restarted)

    def close(self) -> None:
        """Let it finish, and wait for its exit."""
        if self._timer is not None:
            self._timer.cancel()
        if self._process is None:
            return
        assert self._process.stdin is not None
        with contextlib.suppress(OSError):
            self._process.stdin.close()
        if wait_or_kill(self._process, self._goodbye_s) is None:
            self._run.housekeeper.ledger.died(-signal.SIGKILL, self._started_s)
        self._release()

    def _release(self) -> None:
        assert self._process is not None and self._process.stdin is not None
        self._reactor.remove(self._pidfd)
        if (output := self._process.stdout) is not None:
            self._reactor.remove(output.fileno())
            self._take(output.read())
            output.close()
        with contextlib.suppress(OSError):
            self._process.stdin.close()
        os.close(self._pidfd)
        os.close(self._errors)
        self._pidfd = self._errors = -1
        self._process = None
