"""A helper process that exchanges lines of JSON, which nothing waits for."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Mapping

from launcher.base import strict_json
from launcher.posix import spawn
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.reactor import Reactor
from launcher.run.helpers.popen import last_line, start_module, wait_or_kill

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def own_end(env: Mapping[str, str]) -> dict[str, str]:
    """The environment of one that ends by itself when the launcher does: without the run's id."""
    return {name: value for name, value in env.items() if name != RUN_ID_VARIABLE}


def without_shared_memory(env: Mapping[str, str]) -> dict[str, str]:
    """That of a node of which nothing has to be cleaned up.

    But where rmw_fastrtps limits discovery to this machine.
    """
    return {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4", **env}


class JsonLinesProcess:
    """`python -m` with this program; OSError if it cannot be started.

    `on_message` gets what its lines are; lines that are not JSON, as Fast DDS prints some, are
    skipped. When its output ends, it is killed, and `on_end` gets its exit code and the last line
    of its standard error, which is that of the launcher with `shows_errors`.
    """

    def __init__(
        self,
        reactor: Reactor,
        program: str,
        env: Mapping[str, str],
        *,
        on_message: Callable[[Any], object],
        on_end: Callable[[int, str], object],
        shows_errors: bool = False,
    ) -> None:
        self._reactor = reactor
        self._on_message = on_message
        self._on_end = on_end
        self._partial = self._unsent = b""
        self._errors = os.memfd_create("helper-errors", os.MFD_CLOEXEC)
        try:
            self._process = start_module(
                [program],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=None if shows_errors else self._errors,
                env=env,
                bufsize=0,
            )
        except OSError:
            os.close(self._errors)
            raise
        self.pid = self._process.pid
        self.has_ended = False
        spawn.started.add(self.pid)
        assert self._process.stdin is not None and self._process.stdout is not None
        self._in, self._out = self._process.stdin, self._process.stdout
        os.set_blocking(self._in.fileno(), False)
        os.set_blocking(self._out.fileno(), False)
        reactor.add_reader(self._out.fileno(), self._readable)

    # ---- writing, without waiting: one that hangs must not suspend the run

    @property
    def has_unsent(self) -> bool:
        return bool(self._unsent)

    def send(self, message: object, default: Callable[[Any], Any] | None = None) -> None:
        """Nothing if its input is closed; `default` as for `json.dumps`."""
        if self._in.closed:
            return
        is_first = not self._unsent
        self._unsent += strict_json.packed(message, default=default).encode() + b"\n"
        if is_first and self._flush():
            self._reactor.add_writer(self._in.fileno(), self._writable)

    def _writable(self) -> None:
        if not self._flush():
            self._reactor.remove(self._in.fileno())

    def _flush(self) -> bool:
        """Write what the pipe takes; whether something is left."""
        try:
            self._unsent = self._unsent[os.write(self._in.fileno(), self._unsent) :]
        except BlockingIOError:
            return True
        except BrokenPipeError:
            self._unsent = b""  # the end of its output is noticed as well
        return bool(self._unsent)

    def close_input(self) -> None:
        """Let it end."""
        if not self._in.closed:
            self._reactor.remove(self._in.fileno())
            self._in.close()

    # ---- reading

    def _readable(self) -> None:
        chunk = os.read(self._out.fileno(), 65536)
        if not chunk:
            why = last_line(self._errors)
            self._on_end(self.close(), why)
            return
        *lines, self._partial = (self._partial + chunk).split(b"\n")
        for line in lines:
            try:
                message = strict_json.unpacked(line)
            except ValueError:
                continue
            self._on_message(message)
            if self.has_ended:
                return  # closed meanwhile

    def close(self, goodbye_s: float = 0.0) -> int:
        """Kill it unless it exits within this time after the end of its input; its exit code."""
        if not self.has_ended:
            self.has_ended = True
            self.close_input()
            self._reactor.remove(self._out.fileno())
            wait_or_kill(self._process, goodbye_s)
            self._out.close()
            os.close(self._errors)
            spawn.started.discard(self.pid)
        return self._process.returncode
