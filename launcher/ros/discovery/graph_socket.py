"""Ask: the graph as the observer of a run knows it, if one looks at the same domain.

The observer (`bridge`, started by `--ros`) listens beside the run's control socket. It knows what
it has heard of since it started, so it tells ghosts as well: nodes that were killed.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from launcher.control import folder
from launcher.control.folder import ControlError
from launcher.control.server import credentials, listening
from launcher.ros.snapshot.graph import GraphSnapshot, from_document

SUFFIX = ".graph"  # no `.sock`: it is not a run's
ANSWER_TIMEOUT_S = (
    0.3  # who does not answer in this time is not asked: looking ourselves is as fast
)
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


def query(domain_id: int, environment: Mapping[str, str]) -> dict[str, Any]:
    """What an observer has to agree with, to answer."""
    discovery = {name: environment.get(name, "") for name in DISCOVERY}
    return {"domain_id": domain_id, "discovery": discovery}


def graph_socket_path(run_socket: Path) -> Path:
    """Where the observer of the run with this control socket listens."""
    return run_socket.with_suffix(SUFFIX)


def snapshot_of_run(domain_id: int) -> GraphSnapshot | None:
    """What an observer of a run knows; None if there is none, or it does not know all."""
    deadline = time.monotonic() + ANSWER_TIMEOUT_S
    asked = json.dumps(query(domain_id, os.environ)).encode() + b"\n"
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


REQUEST_TIMEOUT_S = 1.0  # for the line of a client
_MOST_BYTES = 64 * 1024

Answer = Callable[[Mapping[str, Any]], Mapping[str, Any]]


class GraphServer:
    """Answers each question, a JSON object on a line, by one; `close()` removes the socket.

    `answer` is called in a thread of its own. `look_after` makes a socket anew that somebody has
    removed. Raises ControlError where it cannot listen.
    """

    def __init__(self, path: Path, answer: Answer) -> None:
        self._path = path
        self._answer = answer
        self._socket = _listening(path)
        self._is_closed = False
        self._lock = threading.Lock()  # who looks after it must not make it anew behind its end
        self._thread = threading.Thread(target=self._serve, name="graph answers", daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:
                if self._is_closed:
                    return
                continue  # made anew
            with connection, contextlib.suppress(OSError, ValueError):
                self._talk(connection)

    def _talk(self, connection: socket.socket) -> None:
        if credentials(connection)[1] not in (os.getuid(), 0):
            return
        connection.settimeout(REQUEST_TIMEOUT_S)
        asked = b""
        while not asked.endswith(b"\n") and len(asked) < _MOST_BYTES:
            chunk = connection.recv(4096)
            if not chunk:
                return
            asked += chunk
        query = json.loads(asked)
        if isinstance(query, dict):
            connection.sendall(json.dumps(self._answer(query)).encode() + b"\n")

    def look_after(self) -> None:
        """Listen anew if the socket has been removed; not before its folder is there again."""
        with self._lock, contextlib.suppress(ControlError):
            if self._is_closed or os.path.lexists(self._path) or not self._path.parent.is_dir():
                return
            old, self._socket = self._socket, _listening(self._path)
            _shut(old)

    def close(self) -> None:
        """Stop."""
        with self._lock:
            self._is_closed = True
            with contextlib.suppress(OSError):
                self._path.unlink()
            _shut(self._socket)
        self._thread.join(REQUEST_TIMEOUT_S)


def _listening(path: Path) -> socket.socket:
    made = listening(path)
    made.setblocking(True)
    return made


def _shut(old: socket.socket) -> None:
    with contextlib.suppress(OSError):
        old.shutdown(socket.SHUT_RDWR)  # wakes who waits for a client
    old.close()
