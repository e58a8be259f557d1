"""`multicast send|receive`: try whether a network passes multicast on, as discovery needs it."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.base.command_line import DEBUG, Command, Parsed, count, option, positive_seconds
from launcher.base.errors import ExitCode
from launcher.base.verb_table import VERBS
from launcher.ros import multicast


def _ttl(word: str) -> int:
    return count(word, 1, multicast.MAX_TTL)


def _send(options: Parsed) -> int:
    print("Sending one UDP multicast datagram...", flush=True)
    multicast.send(options.ttl)
    return ExitCode.OK


def _receive(options: Parsed) -> int:
    print("Waiting for UDP multicast datagram...", flush=True)
    try:
        text, host, port = multicast.receive(options.timeout)
    except KeyboardInterrupt:
        return ExitCode.OK
    print(f"Received from {host}:{port}: '{text}'")
    return ExitCode.OK


COMMAND = Command(
    "multicast",
    VERBS["multicast"],
    commands=(
        Command(
            "multicast send",
            "send one packet",
            options=(option("--ttl N", "let it pass N - 1 routers", _ttl), DEBUG),
            run=_send,
        ),
        Command(
            "multicast receive",
            "wait for one packet, and print it",
            options=(
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
