"""A process that was forked before it is known what it will run: the next start does not wait."""

from __future__ import annotations

import _socket
import os

from launcher.run.warm import preparing_messages

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any

    from launcher.run.warm.forking import Forker


class Spare:
    """Forks one; `pid` is 0 in that process, which has to call `wait`.

    Until `give` it is in the group of the preparing process, and ends with it.
    """

    def __init__(self, forker: Forker) -> None:
        ours, theirs = _socket.socketpair(
            _socket.AF_UNIX, _socket.SOCK_SEQPACKET | _socket.SOCK_CLOEXEC
        )
        self.pid = forker.fork(leads_session=False)
        if self.pid == 0:
            ours, theirs = theirs, ours
        theirs.close()
        self._socket = ours

    def give(self, content: Any, fds: Sequence[int]) -> bool:
        """Let it carry out this start, as the leader of a session; False if it is gone."""
        try:
            preparing_messages.send_request(self._socket, content, fds)
            return bool(self._socket.recv(1))
        except OSError:
            return False
        finally:
            self._socket.close()

    def wait(self) -> tuple[Any, list[int]]:
        """What it is given. Does not return if the preparing process is gone."""
        request = preparing_messages.receive_request(self._socket)
        if request is None:
            os._exit(0)
        os.setsid()
        self._socket.send(b"s")
        self._socket.close()
        return request
