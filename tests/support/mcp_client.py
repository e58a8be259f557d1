"""Clients of `launcher mcp`: that of the SDK, and lines of JSON-RPC."""

from __future__ import annotations

import asyncio
import contextlib
import json
import subprocess
import sys
from collections.abc import Awaitable, Callable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # importing it takes half a second, and each worker collects all tests
    from mcp.client import Client

TIMEOUT_S = 60.0
COMMAND = [sys.executable, "-m", "launcher", "mcp"]


def with_client(
    environment: Mapping[str, str],
    use: Callable[[Client], Awaitable[Any]],
    *words: str,
    mode: str = "auto",
) -> Any:
    """What `use` returns, with the SDK's client of a server that it has started."""
    from mcp.client import Client
    from mcp.client.stdio import StdioServerParameters, stdio_client

    parameters = StdioServerParameters(
        command=COMMAND[0], args=[*COMMAND[1:], *words], env=dict(environment)
    )

    async def serve() -> Any:
        async with Client(stdio_client(parameters), mode=mode) as client:
            return await use(client)

    return asyncio.run(asyncio.wait_for(serve(), TIMEOUT_S))


def mcp_error() -> type[Exception]:
    """What a call raises that the server refuses."""
    from mcp.shared.exceptions import MCPError

    return MCPError


class RawMcp:
    """A server whose lines are written and read here. Use `with`."""

    def __init__(self, environment: Mapping[str, str], *words: str) -> None:
        self.process = subprocess.Popen(
            [*COMMAND, *words],
            env=dict(environment),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._number = 0

    def __enter__(self) -> RawMcp:
        return self

    def __exit__(self, *exc: object) -> None:
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):
                    pipe.close()

    def send(self, method: str, **params: Any) -> int:
        """Send a request; its id."""
        self._number += 1
        self._write({"id": self._number, "method": method, "params": params})
        return self._number

    def notify(self, method: str, **params: Any) -> None:
        self._write({"method": method, "params": params})

    def _write(self, message: dict[str, Any]) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps({"jsonrpc": "2.0", **message}) + "\n")
        self.process.stdin.flush()

    def read(self) -> dict[str, Any]:
        """The next line, which is JSON-RPC."""
        assert self.process.stdout is not None
        message: dict[str, Any] = json.loads(self.process.stdout.readline())
        assert message["jsonrpc"] == "2.0"
        return message

    def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """The answer to a request, when nothing else is open."""
        number = self.send(method, **params)
        answer = self.read()
        assert answer["id"] == number
        return answer

    def initialize(self) -> dict[str, Any]:
        """The handshake; its result."""
        answer = self.ask(
            "initialize",
            protocolVersion="2025-06-18",
            capabilities={},
            clientInfo={"name": "test", "version": "0"},
        )
        self.notify("notifications/initialized")
        result: dict[str, Any] = answer["result"]
        return result

    def call(self, name: str, **arguments: Any) -> dict[str, Any]:
        """The answer to a call of a tool."""
        return self.ask("tools/call", name=name, arguments=arguments)
