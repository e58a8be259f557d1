"""Calls tests of launch_pytest while the loop of their launch runs; a Ctrl-C or SIGTERM ends both.

Every run of pytest loads this module, so what only such tests need is imported later.
"""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import asyncio

_CANCELLATION_S = 1.0  # how long a coroutine may take to end after a Ctrl-C


class LaunchTerminated(KeyboardInterrupt):
    """SIGTERM, or another signal that is to end the program."""


def raise_interrupt(service: Any) -> None:
    """Raise, once, the KeyboardInterrupt of a signal that a launch has taken for its own."""
    signum = getattr(service, "_stop_signal", None)
    if signum is not None:
        service._stop_signal = None
        name = signal.Signals(signum).name
        raise KeyboardInterrupt if signum == signal.SIGINT else LaunchTerminated(name)


def complete(loop: asyncio.AbstractEventLoop, service: Any, test: Any) -> None:
    """Run a test to its end. KeyboardInterrupt once a Ctrl-C has stopped the launch."""
    import asyncio

    raise_interrupt(service)
    call, launch = asyncio.ensure_future(test, loop=loop), service.task
    if launch is not None:
        first = asyncio.FIRST_COMPLETED
        loop.run_until_complete(asyncio.wait({call, launch}, return_when=first))
        if service._stop_signal is not None:
            loop.run_until_complete(launch)
            call.cancel()
            loop.run_until_complete(asyncio.wait({call}, timeout=_CANCELLATION_S))
            raise_interrupt(service)
    loop.run_until_complete(call)


async def in_thread(function: Callable[[], object]) -> None:
    """Call a plain function in a thread, which is left alone where nobody waits any more."""
    import asyncio

    loop = asyncio.get_running_loop()
    ended: asyncio.Future[BaseException | None] = loop.create_future()

    def settle(error: BaseException | None) -> None:
        if not ended.done():
            ended.set_result(error)

    def call() -> None:
        error = None
        try:
            function()
        except BaseException as raised:
            error = raised
        with contextlib.suppress(RuntimeError):  # the loop is closed
            loop.call_soon_threadsafe(settle, error)

    # Unlike those of an executor, the interpreter does not wait for such a thread at its end.
    threading.Thread(target=call, name="launch_pytest", daemon=True).start()
    error = await ended
    if error is not None:
        raise error
