"""Connections that send no whole request."""

from __future__ import annotations

import asyncio
import socket
from typing import Any

import pytest
import uvicorn

from launcher.web.web_server import _Http, _Server

DEADLINE_S = 60.0
GET = b"GET / HTTP/1.1\r\nHost: x\r\n\r\n"


class _Impatient(_Http):
    request_s = 0.05


async def app(scope: Any, receive: Any, send: Any) -> None:
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"hello"})


async def closed(first: bytes, byte: bytes) -> None:
    """Wait until the server closes a connection that goes on sending this byte."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        config = uvicorn.Config(
            app, log_config=None, access_log=False, lifespan="off", http=_Impatient, ws="none"
        )
        server = _Server(config)
        serving = asyncio.create_task(server.serve(sockets=[listening]))
        reader, writer = await asyncio.open_connection(*listening.getsockname())
        writer.write(first)
        reading = asyncio.create_task(reader.read())
        try:
            while not reading.done():
                writer.write(byte)
                await asyncio.wait([reading], timeout=0.005)
            reading.exception()  # it may have been reset
        finally:
            writer.close()
            server.should_exit = True
            await serving


CASES = {
    "nothing": (b"", b""),
    "bytes of a head": (b"GET / HTTP/1.1\r\nX: ", b"x"),
    "bytes of a head after a request": (GET + b"GET / HTTP/1.1\r\nX: ", b"x"),
    "bytes of a body": (b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 10000\r\n\r\n", b"x"),
}


@pytest.mark.parametrize(("first", "byte"), CASES.values(), ids=CASES)
def test_a_connection_without_a_whole_request_is_closed(first: bytes, byte: bytes):
    asyncio.run(asyncio.wait_for(closed(first, byte), DEADLINE_S))
