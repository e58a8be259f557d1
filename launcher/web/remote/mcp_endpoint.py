"""`/mcp` of a server with asyncio: MCP by the transport "streamable HTTP"."""

from __future__ import annotations

import asyncio
import contextlib

from mcp.server.streamable_http_manager import StreamableHTTPSessionManager
from starlette.types import Receive, Scope, Send

from launcher.web.remote.mcp_server import server_of
from launcher.web.remote.toolbox import Toolbox

MOST_SESSIONS = 256
_IDLE_S = 30 * 60.0
_REQUEST_BYTES = 256 * 1024


class McpEndpoint:
    """Sessions of MCP clients, until `close`. Host and Origin are checked before."""

    def __init__(self, toolbox: Toolbox) -> None:
        self._manager = StreamableHTTPSessionManager(
            server_of(toolbox),
            max_sessions=MOST_SESSIONS,
            session_idle_timeout=_IDLE_S,
            max_request_body_size=_REQUEST_BYTES,
        )
        self._is_ready = asyncio.Event()
        self._end = asyncio.Event()
        self._task = asyncio.create_task(self._run())

    async def _run(self) -> None:
        """One task has to enter and to leave the manager."""
        async with self._manager.run():
            self._is_ready.set()
            await self._end.wait()

    async def serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        """An ASGI application."""
        await self._is_ready.wait()
        await self._manager.asgi_app(scope, receive, send)

    async def close(self) -> None:
        """End all sessions."""
        self._end.set()
        with contextlib.suppress(asyncio.CancelledError):
            await self._task
