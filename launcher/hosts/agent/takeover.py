"""A new connection for an agent that has lost its own: the descriptors of another process.

`agent --resume RUN`, which came in by ssh, passes its standard streams to the agent of the run, and
stays until the agent closes them. So the agent needs no port, and obeys only those who can log in.
"""

from __future__ import annotations

import array
import contextlib
import os
import shutil
import socket
import struct
from collections.abc import Callable
from pathlib import Path

from launcher.posix import socket_directory
from launcher.posix.reactor import Reactor

_STREAMS = 3
_CREDENTIALS = struct.Struct("3i")  # pid, user, group


def socket_path(key: str) -> Path:
    """In a folder that only this user can enter; ControlError.

    Not in XDG_RUNTIME_DIR, which is removed when the last session of the user ends.
    """
    path = socket_directory.prepare(key, {"TMPDIR": os.environ.get("TMPDIR", "")}, os.getuid())
    return path.with_suffix(".agent")


def files_folder(path: Path) -> Path:
    """Where an agent with this socket keeps the files of orders."""
    return path.with_suffix(".files")


def remove_abandoned(folder: Path) -> None:
    """Remove what killed agents have left in the folder of sockets."""
    for path in socket_directory.abandoned(folder, ".agent"):
        remove(path)


def remove(path: Path) -> None:
    path.unlink(missing_ok=True)
    shutil.rmtree(files_folder(path), ignore_errors=True)


class TakeoverServer:
    """Listens at `path`; `taken(streams, session)` gets three descriptors, and one to close."""

    def __init__(
        self, reactor: Reactor, path: Path, taken: Callable[[list[int], int], None]
    ) -> None:
        self._reactor = reactor
        self._path = path
        self._taken = taken
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_NONBLOCK)
        remove_abandoned(path.parent)
        self._socket.bind(str(path))
        self._socket.listen(4)
        reactor.add_reader(self._socket.fileno(), self._accept)

    def _accept(self) -> None:
        try:
            connection, _ = self._socket.accept()
        except OSError:
            return
        connection.settimeout(1.0)
        streams: list[int] = []
        if is_ours(connection):
            with contextlib.suppress(OSError):
                streams = _receive(connection)
        if len(streams) != _STREAMS:
            for fd in streams:
                os.close(fd)
            connection.close()
            return
        self._taken(streams, connection.detach())

    def close(self) -> None:
        self._reactor.remove(self._socket.fileno())
        self._socket.close()
        remove(self._path)


def is_ours(connection: socket.socket) -> bool:
    """Whether the other end belongs to the same user."""
    found = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    return int(_CREDENTIALS.unpack(found)[1]) == os.getuid()


def _receive(connection: socket.socket) -> list[int]:
    descriptors = array.array("i")
    room = socket.CMSG_SPACE(_STREAMS * descriptors.itemsize)
    _, ancillary, _, _ = connection.recvmsg(1, room)
    for level, kind, data in ancillary:
        if (level, kind) == (socket.SOL_SOCKET, socket.SCM_RIGHTS):
            descriptors.frombytes(data[: len(data) - len(data) % descriptors.itemsize])
    for fd in descriptors:
        os.set_inheritable(fd, False)
    return list(descriptors)


def hand_over(key: str) -> bool:
    """Pass the standard streams to the agent of this key, and wait until it closes them.

    False if there is no such agent.
    """
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        path = socket_path(key)
        remove_abandoned(path.parent)
        connection.connect(str(path))
        if not is_ours(connection):
            return False
        streams = array.array("i", range(_STREAMS))
        connection.sendmsg([b"."], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, streams)])
    except OSError:
        return False
    null = os.open(os.devnull, os.O_RDWR)
    for number in range(_STREAMS):
        os.dup2(null, number)
    with contextlib.suppress(OSError):
        connection.recv(1)
    return True
