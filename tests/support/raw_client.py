"""A client of the control socket that may violate the protocol."""

from __future__ import annotations

import json
import os
import socket
from pathlib import Path

from tests.support.controlled_run import TIMEOUT_S


class RawClient:
    """Sends any bytes and reads answers."""

    def __init__(self, path: Path) -> None:
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(TIMEOUT_S)
        self.socket.connect(os.fspath(path))
        self._lines = self.socket.makefile("rb")
        self.hello = self.read()

    def __enter__(self) -> RawClient:
        return self

    def __exit__(self, *exc: object) -> None:
        self._lines.close()
        self.socket.close()

    def send(self, data: bytes) -> None:
        self.socket.sendall(data)

    def read(self) -> dict | None:
        """The next line; None when the connection is over."""
        line = self._lines.readline()
        return json.loads(line) if line else None


def error_of(answer: dict | None) -> str:
    assert answer is not None
    assert not answer["ok"]
    return answer["error"]["code"]
