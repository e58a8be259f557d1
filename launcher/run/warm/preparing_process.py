"""The launcher's side of the preparing process."""

from __future__ import annotations

import _socket
import contextlib
import os
import select
import signal
import sys

from launcher.base import strict_json
from launcher.posix import spawn
from launcher.run.warm import preparing_messages

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any

    from launcher.posix.reactor import Reactor, Timer

EXIT_S = 0.2
SILENCE_S = 10.0  # of a process that has something to do; then it is killed
_SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "preparing.py")


class PreparingProcess:
    """Starts it; OSError. `answered(content)` is called for each answer, `ended(why)` once.

    `environment` is complete. Close it.
    """

    def __init__(
        self,
        reactor: Reactor,
        environment: Mapping[str, str],
        *,
        answered: Callable[[dict[str, Any]], object],
        ended: Callable[[str], object],
    ) -> None:
        self._reactor = reactor
        self._answered = answered
        self._ended = ended
        self._timer: Timer | None = None
        self._socket, theirs = _socket.socketpair(
            _socket.AF_UNIX, _socket.SOCK_SEQPACKET | _socket.SOCK_CLOEXEC
        )
        self._socket.setblocking(False)
        try:
            self.pid = self._start(theirs, environment)
            self._pidfd = os.pidfd_open(self.pid)
        except OSError:
            self._socket.close()
            raise
        finally:
            theirs.close()
        self._pidfd_is_open = True
        reactor.add_reader(self._socket.fileno(), self._read)

    @staticmethod
    def _start(theirs: _socket.socket, environment: Mapping[str, str]) -> int:
        number = spawn.keep_free(theirs.fileno(), spawn.FOR_PROCESSES)
        null = os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)
        try:
            return spawn.execute(
                (sys.executable, _SCRIPT, str(number)),
                env=environment,
                streams=(null, null, null),
                inherited=(number,),
            )
        finally:
            os.close(null)

    def send(self, content: object, fds: Sequence[int] = ()) -> None:
        """OSError if it does not take it. From now on it has to answer."""
        preparing_messages.send_request(self._socket, content, fds)
        self.watch()

    def watch(self) -> None:
        """Wait for the next answer for a while."""
        self.rest()
        self._timer = self._reactor.call_later(SILENCE_S, self._is_silent)

    def rest(self) -> None:
        """Nothing is expected of it."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _is_silent(self) -> None:
        self._end(f"it did not answer for {SILENCE_S:g} s")

    def _read(self) -> None:
        try:
            data = self._socket.recv(preparing_messages.ANSWER_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if data:
            self._answered(strict_json.unpacked(data))
        else:
            self._end("")

    def _end(self, why: str) -> None:
        if not why:  # it closes the socket a moment before it is gone
            poll = select.poll()
            poll.register(self._pidfd, select.POLLIN)
            poll.poll(EXIT_S * 1000)
        returncode = self.close()
        self._ended(why or _how_it_ended(returncode))

    def close(self) -> int:
        """Kill it with what it has started, and wait for that; how it ended, as of `spawn.reap`.

        What it has started and not given away (`Scan`) is in its group, and becomes our child.
        """
        if not self._pidfd_is_open:
            return 0
        self.rest()
        self._reactor.remove(self._socket.fileno())
        self._socket.close()
        with contextlib.suppress(OSError):
            os.killpg(self.pid, signal.SIGKILL)
        returncode, _ = spawn.reap(self._pidfd)
        with contextlib.suppress(ChildProcessError):
            while True:
                spawn.started.discard(os.waitpid(-self.pid, 0)[0])
        os.close(self._pidfd)
        self._pidfd_is_open = False
        return returncode


def _how_it_ended(returncode: int) -> str:
    if returncode < 0:
        return f"it was ended by {signal.Signals(-returncode).name}"
    return f"it exited with code {returncode}"
