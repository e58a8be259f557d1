"""Server: listens for the clients of a run, and lets in whoever may steer it."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
import struct
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from launcher.control import folder, protocol
from launcher.control.folder import ControlError
from launcher.control.peer import Exchange, Peer
from launcher.control.protocol import Request
from launcher.control.verbs import BadCallError
from launcher.engine.posix.reactor import Reactor, Timer
from launcher.engine.posix.spawn import keep_free

BACKLOG = 128
MOST_PEERS = 512
RESERVE = 32  # file descriptors that clients leave free, more than processes and log files do
LOOK_S = 2.0  # between two looks whether the socket is still where clients look for it
REST_S = 0.5  # before the next look, when there are no descriptors left for clients
LAST_WORDS_S = 0.2  # how long each client is waited for at the end
_CREDENTIALS = struct.Struct("3i")  # pid, uid, gid


class Server:
    """Owns the socket file. `hello()` is the first line for each client, `serve` answers.

    Clients of the user `owner` and of root are let in. `place()` is where the socket may be made
    again if it is removed (somebody tidies up); ControlError.
    """

    def __init__(
        self,
        reactor: Reactor,
        path: Path,
        *,
        hello: Callable[[], Mapping[str, Any]],
        serve: Callable[[Request, Exchange], None],
        warn: Callable[[str], None],
        owner: int | None = None,
        place: Callable[[], Path] | None = None,
    ) -> None:
        self._reactor = reactor
        self._path = path
        self._hello = hello
        self._serve = serve
        self._warn = warn
        self._owner = os.getuid() if owner is None else owner
        self._peers: list[Peer] = []
        self._rest: Timer | None = None
        self._has_warned = False
        self._has_been_removed = False
        self._socket = listening(path)
        reactor.add_reader(self._socket.fileno(), self._accept)
        self._place = place
        self._look = None if place is None else reactor.call_later(LOOK_S, self._look_for_it)

    @property
    def path(self) -> Path:
        """The socket's file."""
        return self._path

    def _look_for_it(self) -> None:
        self._look = self._reactor.call_later(LOOK_S, self._look_for_it)
        if self._place is None or os.path.lexists(self._path):
            return
        try:
            path = self._place()
            anew = listening(path)
        except ControlError as error:
            self._say_it_was_removed(f"and cannot be made again: {error.message}")
            return
        self._say_it_was_removed("and is made again")
        self._reactor.remove(self._socket.fileno())
        self._socket.close()
        self._socket, self._path = anew, path
        if self._rest is None:
            self._reactor.add_reader(anew.fileno(), self._accept)

    def _say_it_was_removed(self, what: str) -> None:
        if not self._has_been_removed:
            self._has_been_removed = True
            self._warn(f"{self._path}, by which this run is steered, was removed {what}")

    def _accept(self) -> None:
        try:
            connection, _ = self._socket.accept()
        except (BlockingIOError, ConnectionAbortedError):
            return
        except OSError as error:
            self._take_a_rest(error)
            return
        try:
            keep_free(connection.fileno(), RESERVE)
        except OSError as error:
            connection.close()
            self._take_a_rest(error)
            return
        self._welcome(connection)

    def _welcome(self, connection: socket.socket) -> None:
        pid, uid = credentials(connection)
        peer = Peer(self._reactor, connection, serve=self._serve, on_close=self._gone)
        if uid not in (self._owner, 0):
            self._warn(f"refused to be steered by user {uid} (pid {pid})")
            peer.refuse(BadCallError("refused", "this run belongs to somebody else"))
            return
        self._peers.append(peer)
        if len(self._peers) > MOST_PEERS:
            peer.refuse(BadCallError("refused", f"{MOST_PEERS} clients are connected already"))
            return
        peer.write(protocol.encode(self._hello()))

    def _gone(self, peer: Peer) -> None:
        if peer in self._peers:
            self._peers.remove(peer)

    def _take_a_rest(self, error: OSError) -> None:
        """Without descriptors, the socket would call again and again for nothing."""
        if not self._has_warned:
            self._has_warned = True
            reason = os.strerror(error.errno or errno.EMFILE)
            self._warn(f"a client has to wait: {reason}")
        self._reactor.remove(self._socket.fileno())
        self._rest = self._reactor.call_later(REST_S, self._go_on)

    def _go_on(self) -> None:
        self._rest = None
        self._reactor.add_reader(self._socket.fileno(), self._accept)

    def close(self) -> None:
        """Answer what is open, close everything and remove the socket."""
        if self._look is not None:
            self._look.cancel()
        if self._rest is not None:
            self._rest.cancel()
        self._reactor.remove(self._socket.fileno())
        with contextlib.suppress(OSError):
            self._path.unlink()
        self._socket.close()
        for peer in list(self._peers):
            peer.conclude(BadCallError("stopping", "the run has ended"), LAST_WORDS_S)


def listening(path: Path) -> socket.socket:
    """A socket at `path` for our user alone; ControlError."""
    try:
        listening = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    except OSError as error:
        raise ControlError(error.strerror or str(error)) from None
    before = os.umask(0o177)  # nobody else may connect, not even for a moment
    try:
        listening.bind(os.fsencode(folder.not_yet(path)))
        listening.listen(BACKLOG)
        listening.setblocking(False)
        folder.not_yet(path).rename(path)
    except OSError as error:
        listening.close()
        raise ControlError(f"{path}: {error.strerror or error}") from None
    finally:
        os.umask(before)
    return listening


def credentials(connection: socket.socket) -> tuple[int, int]:
    """(pid, uid) of who has connected, as the kernel knows them."""
    raw = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    pid, uid, _ = _CREDENTIALS.unpack(raw)
    return pid, uid


def socket_path(run_id: str) -> Path:
    """Where the socket of this run goes; ControlError."""
    return folder.prepare(run_id, os.environ, os.getuid())
