"""`foxglove`: show the ROS graph to Foxglove and to Lichtblick."""

from __future__ import annotations

import functools

from launcher.base.command_line import Parsed
from launcher.base.option import JSON_LINES, count, number, option
from launcher.base.verb_table import VERBS
from launcher.ros.verb import GraphAccess, dispatch, ros_command

PORT = 8765  # where Foxglove and Lichtblick look first
_QUEUE_MB = 10.0


def _port(word: str) -> int:
    return count(word, 0, 65535)


def _megabytes(word: str) -> float:
    value = number(word)
    if not 0 < value <= 1e5:
        raise ValueError(f"'{word}' is not a number of megabytes")
    return value


def _foxglove(options: Parsed) -> int:
    from launcher.packages.absent_ros import require

    require("foxglove", {"foxglove": "websockets.asyncio.server"})
    from launcher.ros.foxglove.foxglove_server import ServerOptions, serve
    from launcher.ros.foxglove.graph_view import TopicChoice

    choice = TopicChoice(topics=options.topics, exclude=options.exclude, hidden=options.hidden)
    return serve(
        GraphAccess.of(options),
        ServerOptions(
            choice=choice,
            host=options.host,
            port=options.port,
            most_bytes=int(options.queue * 1e6),
            read_only=options.read_only,
            json=options.json,
        ),
    )


COMMAND = ros_command(
    "foxglove",
    VERBS["foxglove"],
    _foxglove,
    option("--host HOST", "address to listen on", default="127.0.0.1"),
    option("--port N", "port to listen on; 0: any that is free", _port, PORT),
    option("--topics RE", "only topics that match"),
    option("--exclude RE", "no topics that match"),
    option("--hidden", "hidden topics and services as well"),
    option("--read-only", "clients cannot publish, call services or set parameters"),
    option(
        "--queue MB",
        "what may wait for a client that reads slowly, before its messages are dropped",
        _megabytes,
        _QUEUE_MB,
    ),
    json=JSON_LINES,
)

main = functools.partial(dispatch, COMMAND)
