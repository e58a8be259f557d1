"""`python -m launcher.console PID FEED LINK`: started by the supervisor, never by a person."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import sys

# All of these are for the launcher, whose end is ours, too: we show how it stops. SIGTTOU would
# stop us for putting the terminal into order after the launcher was killed.
NOT_OURS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGTTOU)
PATIENCE_S = 10.0


def main(words: list[str]) -> int:
    """Talk to the run of the launcher PID; FEED brings its output, LINK its greetings."""
    for signum in NOT_OURS:
        signal.signal(signum, signal.SIG_IGN)
    pid, feed, link = map(int, words)
    asyncio.run(_run(pid, feed, socket.socket(fileno=link)))
    return 1  # it leaves by itself when all went well


async def _run(pid: int, feed: int, link: socket.socket) -> None:
    from launcher.console.session import Session, in_thread
    from launcher.control.runs import wait_for_run
    from launcher.control.socket_directory import ControlError

    try:
        run = await in_thread(lambda: wait_for_run(pid, PATIENCE_S))
    except ControlError:
        return  # the launcher has ended, and the terminal is as it was
    session = Session(run, feed, link, colour=not os.environ.get("NO_COLOR"))
    try:
        if not await session.run_until_end():
            session.tell_of_death()
    finally:
        session.restore()
    os._exit(0)  # the interpreter's own end takes longer, and the launcher waits for ours


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
