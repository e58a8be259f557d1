"""The probe (docs/reference/probe.md) as a child of the server: requests, and graph events."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import os
import sys
from collections.abc import Callable, Mapping
from typing import Any

from launcher.base import strict_json
from launcher.base.text import typed_error
from launcher.posix.cleanup import RUN_ID_VARIABLE

_LINE_LIMIT = 64 * 1024 * 1024
_GOODBYE_S = 2.0
_ERROR_BYTES = 4096

Answer = dict[str, Any]


class PageProbe:
    """`on_event` gets each event, `on_end` the reason when the probe has exited by itself.

    `environment` overrides ours.
    """

    def __init__(
        self,
        on_event: Callable[[dict[str, Any]], None],
        on_end: Callable[[str], None],
        environment: Mapping[str, str] | None = None,
    ) -> None:
        self._on_event = on_event
        self._on_end = on_end
        self._environment = environment or {}
        self._ids = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[Answer]] = {}
        self._process: asyncio.subprocess.Process | None = None
        self._task: asyncio.Task[None] | None = None
        self._is_closing = False

    @property
    def pid(self) -> int | None:
        return None if self._process is None else self._process.pid

    async def start(self) -> None:
        """Start it. Raises OSError."""
        env = {**os.environ, **self._environment}
        env.pop(RUN_ID_VARIABLE, None)
        self._process = await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            "launcher.ros.probe",
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            env=env,
            limit=_LINE_LIMIT,
        )
        self._task = asyncio.create_task(self._read(self._process))

    async def ask(
        self, request: dict[str, Any], on_id: Callable[[int], None] | None = None
    ) -> Answer:
        """The probe's answer: `ok` with `result`, or `error`; `on_id` gets the id to cancel it."""
        number = next(self._ids)
        if on_id is not None:
            on_id(number)
        future: asyncio.Future[Answer] = asyncio.get_running_loop().create_future()
        self._waiting[number] = future
        self.send({**request, "id": number})
        try:
            return await future
        finally:
            self._waiting.pop(number, None)

    def send(self, request: dict[str, Any]) -> None:
        """Send a request whose answer nobody waits for."""
        process = self._process
        if process is None or process.stdin is None or process.returncode is not None:
            self._fail_all()
            return
        line = strict_json.packed({"id": 0, **request}).encode() + b"\n"
        process.stdin.write(line)

    async def _read(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdout is not None and process.stderr is not None
        errors = asyncio.create_task(_last_bytes(process.stderr))
        reason = None
        try:
            while line := await process.stdout.readline():
                self._take(strict_json.unpacked(line))
        except Exception as error:  # else the graph would be the last one for ever
            reason = typed_error(error)
            with contextlib.suppress(ProcessLookupError):
                process.kill()
        code = await process.wait()
        self._fail_all()
        if not self._is_closing:
            text = (await errors).decode(errors="replace").strip()
            last = text.splitlines()[-1] if text else f"it exited with code {code}"
            self._on_end(reason or last)

    def _take(self, answer: Answer) -> None:
        if "event" in answer:
            self._on_event(answer)
            return
        future = self._waiting.get(answer.get("id") or 0)
        if future is not None and not future.done():
            future.set_result(answer)

    def _fail_all(self) -> None:
        for future in self._waiting.values():
            if not future.done():
                future.set_result(
                    {"ok": False, "error": {"message": "the probe is not running", "hint": None}}
                )

    async def close(self) -> None:
        """End it at the end of its input; kill it if it does not."""
        self._is_closing = True
        process = self._process
        if process is None or process.returncode is not None:
            return
        assert process.stdin is not None
        process.stdin.close()
        try:
            await asyncio.wait_for(process.wait(), _GOODBYE_S)
        except (TimeoutError, asyncio.TimeoutError):
            with contextlib.suppress(ProcessLookupError):
                process.kill()
            await process.wait()


async def _last_bytes(stream: asyncio.StreamReader) -> bytes:
    last = b""
    while data := await stream.read(_ERROR_BYTES):
        last = (last + data)[-_ERROR_BYTES:]
    return last
