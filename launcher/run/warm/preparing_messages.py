"""Messages between the launcher and its preparing process, on a Unix socket.

A request is one byte with descriptors, the first of which is a file in memory that has its content
as JSON: a message may be as long as it likes. An answer is JSON.
"""

from __future__ import annotations

import os
import struct

from launcher.base import strict_json

TYPE_CHECKING = False
if TYPE_CHECKING:
    import _socket
    from collections.abc import Sequence
    from typing import Any

ANSWER_BYTES = 64 * 1024
MOST_FDS = 8
_SOL_SOCKET, _SCM_RIGHTS = 1, 1  # of Linux; importing `socket` takes 5 ms


def send_request(socket: _socket.socket, content: object, fds: Sequence[int] = ()) -> None:
    """OSError if the other side is gone, or its queue is full."""
    file = os.memfd_create("launcher-request", os.MFD_CLOEXEC)
    try:
        os.write(file, strict_json.packed(content).encode())
        rights = struct.pack(f"{len(fds) + 1}i", file, *fds)
        socket.sendmsg([b"r"], [(_SOL_SOCKET, _SCM_RIGHTS, rights)])
    finally:
        os.close(file)


def receive_request(socket: _socket.socket) -> tuple[Any, list[int]] | None:
    """(content, descriptors) of the next request; None if the launcher is gone."""
    data, rights, _, _ = socket.recvmsg(1, 4 * MOST_FDS + 64)
    if not data:
        return None
    file, *fds = struct.unpack(f"{len(rights[0][2]) // 4}i", rights[0][2])
    for fd in (file, *fds):
        os.set_inheritable(fd, False)
    with open(file, "rb") as stream:
        stream.seek(0)
        return strict_json.unpacked(stream.read()), fds


def send_answer(socket: _socket.socket, content: object) -> None:
    socket.send(strict_json.packed(content).encode())
