"""`multicast send|receive`: try whether a network passes multicast on, as discovery needs it."""

from __future__ import annotations

import contextlib
import ipaddress
import socket
import struct
from collections.abc import Iterator, Sequence

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG, count, option, positive_seconds
from launcher.base.ros_errors import VerbError
from launcher.base.verb_table import VERBS

# Those of `ros2 multicast`, so that either side may be that one.
_GROUP = "225.0.0.1"
_PORT = 49150
_MAX_TTL = 255
_TEXT = b"Hello World!"
_SIZE = 4096
_HINT = "no network interface takes multicast: ip route, ip link"


def _group(word: str) -> str:
    """An address of a multicast group; ValueError."""
    try:
        if ipaddress.IPv4Address(word).is_multicast:
            return word
    except ValueError:
        pass
    raise ValueError(f"'{word}' is not an address from 224.0.0.0 to 239.255.255.255")


def _send_packet(group: str, port: int, ttl: int | None) -> None:
    """VerbError if no interface takes it."""
    with (
        _errors(f"sent to {group}:{port}"),
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        if ttl is not None:
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, ttl)
        sender.sendto(_TEXT, (group, port))


def _received(group: str, port: int, timeout_s: float | None) -> tuple[str, str, int]:
    """The text of a packet, with host and port of its sender; VerbError, also after the timeout.

    Several processes of a machine may wait, and all get it.
    """
    with (
        _errors(f"received from {group}:{port}"),
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver,
    ):
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        receiver.bind(("", port))
        membership = struct.pack("=4sl", socket.inet_aton(group), socket.INADDR_ANY)
        receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        receiver.settimeout(timeout_s)
        try:
            data, (host, sender_port) = receiver.recvfrom(_SIZE)
        except TimeoutError:
            raise VerbError(f"no packet arrived within {timeout_s:g} s") from None
    return data.decode("utf-8", errors="replace"), host, sender_port


@contextlib.contextmanager
def _errors(done: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise VerbError(f"nothing can be {done}: {error.strerror}", hint=_HINT) from None


def _send(options: Parsed) -> int:
    print("Sending one UDP multicast datagram...", flush=True)
    _send_packet(options.group, options.port, options.ttl)
    return ExitCode.OK


def _receive(options: Parsed) -> int:
    print("Waiting for UDP multicast datagram...", flush=True)
    try:
        text, host, port = _received(options.group, options.port, options.timeout)
    except KeyboardInterrupt:
        return ExitCode.OK
    print(f"Received from {host}:{port}: '{text}'")
    return ExitCode.OK


GROUP = option("--group ADDRESS", f"multicast group (default: {_GROUP})", _group, _GROUP)
PORT = option("--port N", f"UDP port (default: {_PORT})", lambda word: count(word, 1, 65535), _PORT)
COMMAND = Command(
    "multicast",
    VERBS["multicast"],
    commands=(
        Command(
            "multicast send",
            "send one packet",
            options=(
                GROUP,
                PORT,
                option(
                    "--ttl N", "let it pass N - 1 routers", lambda word: count(word, 1, _MAX_TTL)
                ),
                DEBUG,
            ),
            run=_send,
        ),
        Command(
            "multicast receive",
            "wait for one packet, and print it",
            options=(
                GROUP,
                PORT,
                option("--timeout S", "fail after S seconds", positive_seconds),
                DEBUG,
            ),
            run=_receive,
        ),
    ),
)


def main(words: Sequence[str]) -> int:
    parsed = COMMAND.parse(words)
    assert parsed.command.run is not None
    return parsed.command.run(parsed)
