"""`mcp`: serve runs to other programs by the Model Context Protocol, on stdin and stdout."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import Sequence

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


def main(words: Sequence[str]) -> int:
    """Serve until stdin ends; the exit code."""
    options = COMMAND.parse(words)
    require("mcp", "mcp", "`mcp`")
    if sys.stdin.isatty():
        print("note: waiting for messages of an MCP client on stdin", file=sys.stderr)
    asyncio.run(_serve(options.run, read_only=options.read_only or False))
    return ExitCode.OK


async def _serve(run: str | None, *, read_only: bool) -> None:
    from mcp.server.stdio import stdio_server

    from launcher.web.remote.mcp_server import server_of
    from launcher.web.remote.toolbox import Toolbox

    toolbox = Toolbox(run=run, read_only=read_only)
    loop = asyncio.get_running_loop()

    def end(signum: int) -> None:
        # A thread of `stdio_server` reads stdin, and would be waited for. Commands have guards.
        is_interrupt = signum == signal.SIGINT
        os._exit(ExitCode.INTERRUPTED if is_interrupt else ExitCode.TERMINATED)

    for signum in heeded((signal.SIGINT, signal.SIGTERM, signal.SIGHUP)):
        loop.add_signal_handler(signum, end, signum)
    server = server_of(toolbox)
    try:
        async with stdio_server() as (reading, writing):
            await server.run(reading, writing, server.create_initialization_options())
    finally:
        await toolbox.close()
