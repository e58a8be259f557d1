"""`python -m launcher.control.console PID FEED LINK`, which the supervisor starts.

FEED and LINK are file descriptors: of the launcher's output, and of a socket for the handover.
"""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import sys

from launcher.posix import dispositions

# The launcher handles these signals; the console shows how it stops, and exits after it. SIGTTOU
# would suspend us when we restore the terminal of a launcher that was killed.
IGNORED = (*dispositions.ENDING, signal.SIGTTOU)
CONNECT_TIMEOUT_S = 10.0


def main(words: list[str]) -> int:
    dispositions.ignore(IGNORED)
    pid, feed, link = map(int, words)
    asyncio.run(_run(pid, feed, socket.socket(fileno=link)))
    return 1  # `_run` exits by itself, unless the launcher has exited before


async def _run(pid: int, feed: int, link: socket.socket) -> None:
    from launcher.control.active_runs import wait_for_run
    from launcher.control.console.console_session import ConsoleSession, in_thread
    from launcher.posix.socket_directory import ControlError

    try:
        run = await in_thread(lambda: wait_for_run(pid, CONNECT_TIMEOUT_S))
    except ControlError:
        return  # the launcher has exited; the terminal is unchanged
    session = ConsoleSession(run, feed, link, colour=not os.environ.get("NO_COLOR"))
    try:
        if not await session.run_until_end():
            session.report_kill()
    finally:
        session.restore()
    os._exit(0)  # faster than the interpreter's own exit, for which the launcher would wait


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
