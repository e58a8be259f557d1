"""A client of the server for Foxglove to which nothing can be sent any more."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosedError

from launcher.ros.foxglove.client_session import ClientSession

DEADLINE_S = 60.0


class Socket:
    """A connection that is open until it is aborted, and takes nothing."""

    remote_address = ("127.0.0.1", 1)

    def __init__(self) -> None:
        self.transport = SimpleNamespace(abort=self._abort)
        self._closed = asyncio.Event()

    def _abort(self) -> None:
        self._closed.set()

    async def send(self, message: Any) -> None:
        raise UnicodeEncodeError("utf-8", "\udcff", 0, 1, "surrogates not allowed")

    def __aiter__(self) -> Socket:
        return self

    async def __anext__(self) -> Any:
        await self._closed.wait()
        raise ConnectionClosedError(None, None)


def test_what_ends_the_writer_ends_the_connection(capsys: pytest.CaptureFixture[str]):
    async def work() -> None:
        session = ClientSession(Socket(), None, 7, 1000)
        session.send("text")
        await session.run()

    asyncio.run(asyncio.wait_for(work(), DEADLINE_S))
    assert "client 7 is disconnected: UnicodeEncodeError" in capsys.readouterr().err
