"""The control socket of a run: accepts connections of its owner and root."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
import struct
from collections.abc import Callable, Mapping
from pathlib import Path

from launcher.base.run_verb import BadCallError
from launcher.control import protocol
from launcher.control.control_service import Service
from launcher.control.log_followers import Logs
from launcher.control.peer import Exchange, Peer
from launcher.control.protocol import Request
from launcher.posix import socket_directory
from launcher.posix.reactor import Reactor, Timer
from launcher.posix.socket_directory import ControlError
from launcher.posix.spawn import keep_free
from launcher.run.output.screen_filters import ScreenFilters
from launcher.run.part import Part, When

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.processes.process import Process
    from launcher.run.run import Run


BACKLOG = 128
MAX_PEERS = 512
RESERVE = 32  # file descriptors left free by clients, more than by processes and log files
CHECK_S = 2.0  # between two checks that the socket file still exists
REST_S = 0.5  # without accepting clients, if there are no file descriptors left
CLOSE_S = 0.2  # for each client to read its last answers
_CREDENTIALS = struct.Struct("3i")  # pid, uid, gid


class Server:
    """Accepts clients: `hello()` is the first line for each of them, `serve` handles requests.

    `place()` is the path of the socket; it is created again if it is removed. Raises ControlError.
    """

    def __init__(
        self,
        reactor: Reactor,
        place: Callable[[], Path],
        *,
        hello: Callable[[], Mapping[str, Any]],
        serve: Callable[[Request, Exchange], None],
        warn: Callable[[str], None],
        owner: int | None = None,
    ) -> None:
        self._reactor = reactor
        self._place = place
        self.path = place()
        self._hello = hello
        self._serve = serve
        self._warn = warn
        self._owner = os.getuid() if owner is None else owner
        self._peers: list[Peer] = []
        self._rest: Timer | None = None
        self._has_warned = False
        self._has_been_removed = False
        self._socket = listening(self.path)
        reactor.add_reader(self._socket.fileno(), self._accept)
        self._check = reactor.call_later(CHECK_S, self._check_file)

    def _check_file(self) -> None:
        self._check = self._reactor.call_later(CHECK_S, self._check_file)
        if os.path.lexists(self.path):
            return
        try:
            path = self._place()
            new = listening(path)
        except ControlError as error:
            self._warn_removed(f"and cannot be created again: {error.message}")
            return
        self._warn_removed("and is created again")
        self._reactor.remove(self._socket.fileno())
        self._socket.close()
        self._socket, self.path = new, path
        if self._rest is None:
            self._reactor.add_reader(new.fileno(), self._accept)

    def _warn_removed(self, what: str) -> None:
        if not self._has_been_removed:
            self._has_been_removed = True
            self._warn(f"the control socket {self.path} was removed {what}")

    def _accept(self) -> None:
        try:
            connection, _ = self._socket.accept()
        except (BlockingIOError, ConnectionAbortedError):
            return
        except OSError as error:
            self._pause(error)
            return
        try:
            keep_free(connection.fileno(), RESERVE)
        except OSError as error:
            connection.close()
            self._pause(error)
            return
        self._greet(connection)

    def _greet(self, connection: socket.socket) -> None:
        pid, uid = credentials(connection)
        peer = Peer(self._reactor, connection, serve=self._serve, on_close=self._gone)
        if uid not in (self._owner, 0):
            self._warn(f"refused a connection of user {uid} (pid {pid})")
            peer.refuse(BadCallError("refused", "this run belongs to another user"))
            return
        self._peers.append(peer)
        if len(self._peers) > MAX_PEERS:
            peer.refuse(BadCallError("refused", f"{MAX_PEERS} clients are connected already"))
            return
        peer.write(protocol.encode(self._hello()))

    def _gone(self, peer: Peer) -> None:
        if peer in self._peers:
            self._peers.remove(peer)

    def _pause(self, error: OSError) -> None:
        """Stop accepting for a moment: without file descriptors this would be a busy loop."""
        if not self._has_warned:
            self._has_warned = True
            reason = os.strerror(error.errno or errno.EMFILE)
            self._warn(f"cannot accept clients: {reason}")
        self._reactor.remove(self._socket.fileno())
        self._rest = self._reactor.call_later(REST_S, self._resume)

    def _resume(self) -> None:
        self._rest = None
        self._reactor.add_reader(self._socket.fileno(), self._accept)

    def close(self) -> None:
        """Answer open requests, close all connections and remove the socket."""
        self._check.cancel()
        if self._rest is not None:
            self._rest.cancel()
        self._reactor.remove(self._socket.fileno())
        with contextlib.suppress(OSError):
            self.path.unlink()
        self._socket.close()
        for peer in list(self._peers):
            peer.conclude(BadCallError("stopping", "the run has ended"), CLOSE_S)


def listening(path: Path) -> socket.socket:
    """A socket at `path` that only this user may connect to; ControlError."""
    try:
        listening = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    except OSError as error:
        raise ControlError(error.strerror or str(error)) from None
    before = os.umask(0o177)  # no other user may connect, not even for a moment
    try:
        listening.bind(os.fsencode(socket_directory.temporary(path)))
        listening.listen(BACKLOG)
        listening.setblocking(False)
        socket_directory.temporary(path).rename(path)
    except OSError as error:
        listening.close()
        raise ControlError(f"{path}: {error.strerror or error}") from None
    finally:
        os.umask(before)
    return listening


def credentials(connection: socket.socket) -> tuple[int, int]:
    """(pid, uid) of the other end."""
    raw = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    pid, uid, _ = _CREDENTIALS.unpack(raw)
    return pid, uid


class ControlSocket(Part):
    """Opened when the first processes have been started."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._filters = ScreenFilters(run.all_processes.values(), run.log)
        self._logs = Logs(run)
        self._server: Server | None = None

    def begin(self) -> None:
        """Open it, then the parts that are clients of it; warns if there is no place for it."""
        run = self.run
        service = Service(run, self._filters, self._logs)
        try:
            self._server = Server(
                run.reactor,
                lambda: socket_directory.prepare(run.id, os.environ, os.getuid()),
                hello=service.hello,
                serve=service.serve,
                warn=run.log.warn,
            )
        except ControlError as error:
            run.log.warn(f"cannot open the control socket: {error.message}")
            return
        run.socket = str(self._server.path)
        run.parts.begin(When.SERVED)

    def adding(self, process: Process) -> None:
        self._filters.adopt(process)
        self._logs.subscribe()

    def close(self) -> None:
        if self._server is not None:
            self._server.close()
