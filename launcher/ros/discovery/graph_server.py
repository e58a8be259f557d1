"""Serves the graph to other commands of the same user, which `graph_socket` reads."""

from __future__ import annotations

import contextlib
import os
import socket
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from launcher.base import strict_json
from launcher.control.control_server import credentials, listening
from launcher.posix.socket_directory import ControlError

REQUEST_TIMEOUT_S = 1.0  # for the line of a client
_MAX_BYTES = 64 * 1024

Answer = Callable[[Mapping[str, Any]], Mapping[str, Any]]


class GraphServer:
    """Answers requests, a JSON object on a line, in a separate thread; `close()` ends it.

    Raises ControlError where it cannot listen.
    """

    def __init__(self, path: Path, answer: Answer) -> None:
        self._path = path
        self._answer = answer
        self._socket = _listening(path)
        self._is_closed = False
        self._lock = threading.Lock()  # `restore` must not open the socket again after `close`
        self._thread = threading.Thread(target=self._serve, name="graph server", daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:
                if self._is_closed:
                    return
                continue  # replaced by `restore`
            # Whatever a client sends, the next one is served.
            with connection, contextlib.suppress(Exception):
                self._serve_client(connection)

    def _serve_client(self, connection: socket.socket) -> None:
        if credentials(connection)[1] not in (os.getuid(), 0):
            return
        end_s = time.monotonic() + REQUEST_TIMEOUT_S
        line = b""
        while not line.endswith(b"\n") and len(line) < _MAX_BYTES:
            left_s = end_s - time.monotonic()
            if left_s <= 0:
                return
            connection.settimeout(left_s)
            chunk = connection.recv(4096)
            if not chunk:
                return
            line += chunk
        request = strict_json.loads(line)
        if isinstance(request, dict):
            connection.sendall(strict_json.dumps(self._answer(request)).encode() + b"\n")

    def restore(self) -> None:
        """Restore the socket file if it was removed, once its folder exists again."""
        with self._lock, contextlib.suppress(ControlError):
            if self._is_closed or os.path.lexists(self._path) or not self._path.parent.is_dir():
                return
            old, self._socket = self._socket, _listening(self._path)
            _shut(old)

    def close(self) -> None:
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
        old.shutdown(socket.SHUT_RDWR)  # wakes the thread that waits for a client
    old.close()
