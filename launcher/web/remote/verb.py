"""`mcp`: serve runs to other programs by the Model Context Protocol, on stdin and stdout."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import threading
from collections.abc import AsyncIterator, Sequence
from typing import Any, NoReturn

from launcher.base import strict_json
from launcher.base.command_line import Command
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG, option
from launcher.base.verb_table import VERBS
from launcher.packages.extras import require
from launcher.posix.dispositions import heeded

COMMAND = Command(
    "mcp",
    VERBS["mcp"],
    synopsis="[--run ID] [--read-only]",
    about="""\
Serve the Model Context Protocol on stdin and stdout until stdin ends, for a client that starts this
command. The tools are verbs: ps, logs, events, graph, wait, start, stop, restart and others. Runs
may begin and end meanwhile; if several are active, each call names one.""",
    options=(
        option("--run ID", "serve only this run: id, pid or target, or the beginning of one"),
        option("--read-only", "only tools that change nothing"),
        DEBUG,
    ),
)

_PARSE_ERROR = -32700


def main(words: Sequence[str]) -> int:
    """Serve until stdin ends; the exit code."""
    options = COMMAND.parse(words)
    require("mcp", "mcp", "`mcp`")
    if sys.stdin.isatty():
        print("note: waiting for messages of an MCP client on stdin", file=sys.stderr)
    asyncio.run(_serve(options.run, read_only=options.read_only or False))
    return ExitCode.OK


class _ProtocolOutput:
    """The standard output, which nothing else in this process can write to any more.

    It is what `stdio_server` uses of a file. If the client reads no more, this process ends.
    """

    def __init__(self) -> None:
        sys.stdout.flush()
        self._file = os.fdopen(os.dup(1), "w", encoding="utf-8")
        self._writing = threading.Lock()
        os.dup2(2, 1)

    async def write(self, text: str) -> None:
        await asyncio.to_thread(self._write, text)

    def _write(self, text: str) -> None:
        try:
            with self._writing:
                self._file.write(text)
                self._file.flush()
        except BrokenPipeError:
            _leave(ExitCode.OK)

    async def flush(self) -> None:
        """Each message is written at once."""


async def _messages(output: _ProtocolOutput) -> AsyncIterator[str]:
    """The lines of the standard input, which nothing else in this process can read any more.

    What is not JSON gets the error of JSON-RPC 2.0 for that, which the package does not send.
    """
    import anyio

    file = os.fdopen(os.dup(0), encoding="utf-8", errors="replace")
    null = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null, 0)
    os.close(null)
    async for line in anyio.wrap_file(file):
        try:
            strict_json.loads(line)
        except ValueError as error:
            if line.strip():
                fault = {"code": _PARSE_ERROR, "message": f"Parse error: {error}"}
                answer = {"jsonrpc": "2.0", "id": None, "error": fault}
                await output.write(strict_json.packed(answer) + "\n")
        else:
            yield line


def _leave(code: int) -> NoReturn:
    """End this process though a thread reads stdin; guards end the commands."""
    os._exit(code)


async def _serve(run: str | None, *, read_only: bool) -> None:
    from mcp.server.stdio import stdio_server

    from launcher.web.remote.mcp_server import server_of
    from launcher.web.remote.toolbox import Toolbox

    toolbox = Toolbox(run=run, read_only=read_only)
    loop = asyncio.get_running_loop()
    for signum in heeded((signal.SIGINT, signal.SIGTERM, signal.SIGHUP)):
        is_interrupt = signum == signal.SIGINT
        code = ExitCode.INTERRUPTED if is_interrupt else ExitCode.TERMINATED
        loop.add_signal_handler(signum, _leave, code)
    server = server_of(toolbox)
    output: Any = _ProtocolOutput()
    try:
        lines: Any = _messages(output)
        async with stdio_server(lines, output) as (reading, writing):
            await server.run(reading, writing, server.create_initialization_options())
    finally:
        await toolbox.close()
