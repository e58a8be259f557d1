"""The connection to a run: what an item raises does not vanish."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

from launcher.web.run_client import RunClient

DEADLINE_S = 60.0


def failure_of(line: bytes, folder: Path) -> Exception | None:
    """What a client whose reader of items fails has to report when a run has sent this line."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(b'{"run": {}}\n')
        await reader.readline()
        writer.write(line)
        writer.close()

    def fail(item: dict[str, Any]) -> None:
        raise ValueError(item["text"])

    async def work() -> Exception | None:
        ended = asyncio.Event()
        client = RunClient(ended.set)
        async with await asyncio.start_unix_server(serve, folder / "socket"):
            await client.connect(folder / "socket")
            client.follow("logs", fail)
            await asyncio.wait_for(ended.wait(), DEADLINE_S)
            await client.close()
        return client.failure

    return asyncio.run(work())


def test_an_error_about_an_item_is_the_failure_of_the_client(tmp_path: Path):
    found = failure_of(b'{"id": 1, "item": {"text": "odd"}}\n', tmp_path)
    assert isinstance(found, ValueError) and str(found) == "odd"


def test_a_line_that_is_cut_short_is_the_end_of_the_run(tmp_path: Path):
    assert failure_of(b'{"id": 1, "item": {"te', tmp_path) is None
