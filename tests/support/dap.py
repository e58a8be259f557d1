"""The Debug Adapter Protocol, as far as an editor needs it to attach and go on."""

from __future__ import annotations

import json
import socket
from typing import Any

TIMEOUT_S = 60.0


class DapClient:
    """A connection to a debug adapter; use `with`."""

    def __init__(self, host: str, port: int) -> None:
        self._socket = socket.create_connection((host, port), timeout=TIMEOUT_S)
        self._buffer = b""
        self._sent = 0

    def __enter__(self) -> DapClient:
        return self

    def __exit__(self, *exc: object) -> None:
        self._socket.close()

    def attach(self) -> None:
        """Attach, and let the program go on."""
        self._send("initialize", adapterID="test")
        self._send("attach", justMyCode=False)
        self._await(lambda message: message.get("event") == "initialized")
        self._send("configurationDone")
        self._await(lambda message: message.get("command") == "attach" and message["success"])

    def _send(self, command: str, **arguments: object) -> None:
        self._sent += 1
        message = {
            "seq": self._sent,
            "type": "request",
            "command": command,
            "arguments": arguments,
        }
        body = json.dumps(message).encode()
        self._socket.sendall(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))

    def _await(self, is_it: Any) -> None:
        while not is_it(self._receive()):
            pass

    def _receive(self) -> dict[str, Any]:
        while b"\r\n\r\n" not in self._buffer:
            self._read()
        head, _, rest = self._buffer.partition(b"\r\n\r\n")
        size = int(head.rpartition(b":")[2])
        while len(rest) < size:
            self._read()
            rest = self._buffer.partition(b"\r\n\r\n")[2]
        self._buffer = rest[size:]
        message: dict[str, Any] = json.loads(rest[:size])
        return message

    def _read(self) -> None:
        part = self._socket.recv(65536)
        assert part, "the adapter has closed the connection"
        self._buffer += part
