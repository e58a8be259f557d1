"""Answering: tells other commands of the same user the graph, on a socket (see `ask`)."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from launcher.control.folder import ControlError
from launcher.control.server import credentials, listening

REQUEST_TIMEOUT_S = 1.0  # for the line of a client
_MOST_BYTES = 64 * 1024

Answer = Callable[[Mapping[str, Any]], Mapping[str, Any]]


class Answering:
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
        question = json.loads(asked)
        if isinstance(question, dict):
            connection.sendall(json.dumps(self._answer(question)).encode() + b"\n")

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
