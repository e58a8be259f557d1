"""`web`: serve the page of a running launch to the browser."""

from __future__ import annotations

import asyncio
import signal
import sys
from collections.abc import Sequence

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG, option
from launcher.base.program import browse
from launcher.base.verb_table import VERBS
from launcher.control.active_runs import find_run
from launcher.posix.dispositions import heeded
from launcher.run.part_options import page_options
from launcher.web.page_options import require_page

COMMAND = Command(
    "web",
    VERBS["web"],
    synopsis="[--run ID] [options]",
    about="""\
Print the link of a page that shows and controls a running launch, and serve it until Ctrl-C or the
end of the run. A run that is started with --web has the page from the start.""",
    options=(
        option("--run ID", "id, pid or target of the run, or the beginning of one of these"),
        option("--open", "open the page in the browser"),
        *page_options(""),
        DEBUG,
    ),
)


def main(words: Sequence[str]) -> int:
    """Serve the page; the exit code."""
    options = COMMAND.parse(words)
    require_page("the page")
    run = find_run(options.run, _warn, read_only=True)
    return asyncio.run(_serve(options, str(run.path)))


async def _serve(options: Parsed, socket: str) -> int:
    from launcher.web.web_server import DEFAULT_HOST, PageSettings, WebServer, risk

    certificate, key = options.tls or (None, None)
    settings = PageSettings(
        socket=socket,
        host=options.host or DEFAULT_HOST,
        port=options.port,
        token_file=options.token,
        certificate=certificate,
        key=key,
        read_only=options.read_only,
    )
    server = WebServer(settings)
    if warning := risk(settings):
        _warn(warning)
    loop = asyncio.get_running_loop()
    for signum in heeded((signal.SIGINT, signal.SIGTERM, signal.SIGHUP)):
        loop.add_signal_handler(signum, server.stop)

    def show(link: str) -> None:
        print(link, flush=True)
        if options.open:
            browse(link)

    await server.serve(show)
    if server.has_ended:
        print("the run has ended", file=sys.stderr)
    return ExitCode.OK


def _warn(text: str) -> None:
    print(f"note: {text}", file=sys.stderr)
