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

from launcher.control.server import credentials, listening

PATIENCE_S = 1.0  # for a question that does not come
_MOST_BYTES = 64 * 1024

Answer = Callable[[Mapping[str, Any]], Mapping[str, Any]]


class Answering:
    """Answers each question, a JSON object on a line, by one; `close()` removes the socket.

    `answer` is called in a thread of its own. Raises ControlError where it cannot listen.
    """

    def __init__(self, path: Path, answer: Answer) -> None:
        self._path = path
        self._answer = answer
        self._socket = listening(path)
        self._socket.setblocking(True)
        self._thread = threading.Thread(target=self._serve, name="graph answers", daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:
                return  # closed
            with connection, contextlib.suppress(OSError, ValueError):
                self._talk(connection)

    def _talk(self, connection: socket.socket) -> None:
        if credentials(connection)[1] not in (os.getuid(), 0):
            return
        connection.settimeout(PATIENCE_S)
        asked = b""
        while not asked.endswith(b"\n") and len(asked) < _MOST_BYTES:
            chunk = connection.recv(4096)
            if not chunk:
                return
            asked += chunk
        question = json.loads(asked)
        if isinstance(question, dict):
            connection.sendall(json.dumps(self._answer(question)).encode() + b"\n")

    def close(self) -> None:
        """Stop."""
        with contextlib.suppress(OSError):
            self._path.unlink()
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)  # wakes the thread
        self._socket.close()
        self._thread.join(PATIENCE_S)
