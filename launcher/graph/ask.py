"""Ask: the graph as the observer of a run knows it, if one looks at the same domain.

The observer (`bridge`, started by `--ros`) listens beside the run's control socket. It knows what
it has heard of since it started, so it tells ghosts as well: nodes that were killed.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from launcher.control import folder
from launcher.graph.look import Look, from_document

SUFFIX = ".graph"  # no `.sock`: it is not a run's
ANSWER_TIMEOUT_S = 0.3  # who does not answer in this time is not asked: looking ourselves is as fast
# What decides who sees whom, besides the domain.
DISCOVERY = (
    "RMW_IMPLEMENTATION",
    "ROS_AUTOMATIC_DISCOVERY_RANGE",
    "ROS_LOCALHOST_ONLY",
    "ROS_STATIC_PEERS",
    "ROS_DISCOVERY_SERVER",
    "ROS_SECURITY_ENABLE",
    "FASTDDS_BUILTIN_TRANSPORTS",
    "FASTRTPS_DEFAULT_PROFILES_FILE",
    "FASTDDS_DEFAULT_PROFILES_FILE",
    "CYCLONEDDS_URI",
)


def question(domain_id: int, environment: Mapping[str, str]) -> dict[str, Any]:
    """What an observer has to agree with, to answer."""
    discovery = {name: environment.get(name, "") for name in DISCOVERY}
    return {"domain_id": domain_id, "discovery": discovery}


def graph_socket(run_socket: Path) -> Path:
    """Where the observer of the run with this control socket listens."""
    return run_socket.with_suffix(SUFFIX)


def look_of_a_run(domain_id: int) -> Look | None:
    """What an observer of a run knows; None if there is none, or it does not know all."""
    deadline = time.monotonic() + ANSWER_TIMEOUT_S
    asked = json.dumps(question(domain_id, os.environ)).encode() + b"\n"
    for path in _sockets():
        try:
            if look := _answer(path, asked, deadline).get("look"):
                return from_document(look)
        except ConnectionRefusedError:  # an observer that was killed
            with contextlib.suppress(OSError):
                path.unlink()
        except (OSError, ValueError, KeyError, TypeError):
            continue  # too slow, or of another version
    return None


def _sockets() -> Iterator[Path]:
    for place in folder.candidates(os.environ, os.getuid()):
        with contextlib.suppress(OSError):
            if folder.problem_of(place, os.getuid()) is None:
                yield from (path for path in place.iterdir() if path.suffix == SUFFIX)


def _answer(path: Path, asked: bytes, deadline: float) -> dict[str, Any]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
        _limit(connection, deadline)
        connection.connect(os.fsencode(path))
        connection.sendall(asked)
        answer = b""
        while not answer.endswith(b"\n"):
            _limit(connection, deadline)
            chunk = connection.recv(1 << 16)
            if not chunk:
                raise ConnectionResetError
            answer += chunk
    found: dict[str, Any] = json.loads(answer)
    return found


def _limit(connection: socket.socket, deadline: float) -> None:
    left_s = deadline - time.monotonic()
    if left_s <= 0:
        raise TimeoutError
    connection.settimeout(left_s)
