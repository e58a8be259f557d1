"""Starts the process that watches files (launcher.run.watch), and restarts it if it dies."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Mapping

from launcher.base import strict_json
from launcher.base.text import how_it_ended
from launcher.posix import spawn
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.reactor import Reactor, Timer
from launcher.run.helpers.popen import last_line, start_module

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

MAX_STARTS = 4  # then the run continues without one
RESTART_DELAY_S = 0.5


class FileWatcher:
    """`on_message` gets its messages; `on_start` is called when it has to be told everything.

    It ends with the launcher, since its input ends then.
    """

    def __init__(
        self,
        reactor: Reactor,
        env: Mapping[str, str],
        warn: Callable[[str], None],
        *,
        on_start: Callable[[], None],
        on_message: Callable[[Mapping[str, Any]], None],
    ) -> None:
        self._reactor = reactor
        self._env = {name: value for name, value in env.items() if name != RUN_ID_VARIABLE}
        self._warn = warn
        self._on_start = on_start
        self._on_message = on_message
        self._process: subprocess.Popen[bytes] | None = None
        self._errors = -1
        self._started = 0
        self._timer: Timer | None = None
        self._partial = self._unsent = b""

    @property
    def pid(self) -> int | None:
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        self._timer = None
        self._started += 1
        self._errors = os.memfd_create("watch-errors", os.MFD_CLOEXEC)
        try:
            self._process = start_module(
                ["launcher.run.watch"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                env=self._env,
                bufsize=0,
            )
        except OSError as error:
            os.close(self._errors)
            self._warn(f"files are not watched: {error.strerror}")
            return
        spawn.started.add(self._process.pid)
        assert self._process.stdin is not None and self._process.stdout is not None
        self._in, self._out = self._process.stdin.fileno(), self._process.stdout.fileno()
        os.set_blocking(self._in, False)
        os.set_blocking(self._out, False)
        self._reactor.add_reader(self._out, self._readable)
        self._on_start()

    def send(self, message: Mapping[str, object]) -> None:
        """Without waiting: one that hangs must not suspend the run."""
        if self._process is None:
            return  # it will be told everything
        is_first = not self._unsent
        self._unsent += strict_json.packed(message).encode() + b"\n"
        if is_first and self._flush():
            self._reactor.add_writer(self._in, self._writable)

    def _writable(self) -> None:
        if not self._flush():
            self._reactor.remove(self._in)

    def _flush(self) -> bool:
        """Write what the pipe takes; whether something is left."""
        try:
            self._unsent = self._unsent[os.write(self._in, self._unsent) :]
        except BlockingIOError:
            return True
        except BrokenPipeError:
            self._unsent = b""  # the end of its output is noticed as well
        return bool(self._unsent)

    def _readable(self) -> None:
        chunk = os.read(self._out, 65536)
        if not chunk:
            self._ended()
            return
        *lines, self._partial = (self._partial + chunk).split(b"\n")
        for line in lines:
            self._on_message(strict_json.unpacked(line))
            if self._process is None:
                return  # closed meanwhile

    def _ended(self) -> None:
        assert self._process is not None
        code = self._process.wait()
        line = last_line(self._errors)
        reason = f": {line}" if line else ""
        self._release()
        is_restarted = self._started < MAX_STARTS
        what = "restarting it" if is_restarted else "files are not watched any more"
        self._warn(f"the file watcher died ({how_it_ended(code)}){reason}; {what}")
        if is_restarted:
            self._timer = self._reactor.call_later(RESTART_DELAY_S, self.start)

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._process is not None:
            self._process.kill()  # it has nothing to clean up
            self._process.wait()
            self._release()

    def _release(self) -> None:
        assert self._process is not None
        assert self._process.stdin is not None and self._process.stdout is not None
        self._reactor.remove(self._in)
        self._reactor.remove(self._out)
        self._process.stdin.close()
        self._process.stdout.close()
        os.close(self._errors)
        spawn.started.discard(self._process.pid)
        self._process = None
        self._partial = self._unsent = b""
