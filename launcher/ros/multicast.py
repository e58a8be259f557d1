"""One UDP packet by multicast, sent or received, to try whether a network passes it on.

Group and port are those of `ros2 multicast`, so that either side may be that one.
"""

from __future__ import annotations

import contextlib
import socket
import struct
from collections.abc import Iterator

from launcher.base.ros_errors import VerbError

GROUP = "225.0.0.1"
PORT = 49150
MAX_TTL = 255
_TEXT = b"Hello World!"
_SIZE = 4096
_HINT = "no network interface takes multicast: ip route, ip link"


def send(ttl: int | None) -> None:
    """VerbError if no interface takes it."""
    with _errors("sent to"), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        if ttl is not None:
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, struct.pack("b", ttl))
        sender.sendto(_TEXT, (GROUP, PORT))


def receive(timeout_s: float | None) -> tuple[str, str, int]:
    """The text of one packet, with host and port of its sender; VerbError, also after the timeout.

    Several processes of a machine may wait, and all get it.
    """
    with _errors("received from"), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        receiver.bind(("", PORT))
        membership = struct.pack("=4sl", socket.inet_aton(GROUP), socket.INADDR_ANY)
        receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        receiver.settimeout(timeout_s)
        try:
            data, (host, port) = receiver.recvfrom(_SIZE)
        except TimeoutError:
            raise VerbError(f"no packet arrived within {timeout_s:g} s") from None
    return data.decode("utf-8", errors="replace"), host, port


@contextlib.contextmanager
def _errors(done: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        text = f"nothing can be {done} {GROUP}:{PORT}: {error.strerror}"
        raise VerbError(text, hint=_HINT) from None
