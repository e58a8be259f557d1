"""AsyncSafeSignalManager: handlers of signals that run in an asyncio loop."""

from __future__ import annotations

import os
import signal
import socket
from collections.abc import Callable

from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    import asyncio

Handler = Callable[[int], object]


@public("launch.utilities.signal_management")
class AsyncSafeSignalManager:
    """Calls handlers in an asyncio loop while its context is open; may be nested and re-entered.

    Signals also need a handler of `signal.signal`, which may do nothing. ValueError outside of the
    main thread.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self.__loop = loop
        self.__handlers: dict[int, Handler] = {}
        self.__sockets: tuple[socket.socket, socket.socket] | None = None
        self.__before = -1

    def handle(self, signum: int, handler: Handler | None) -> Handler | None:
        """Set the handler of a signal, or remove it; returns the previous one."""
        signum = signal.Signals(signum)
        if handler is not None and not callable(handler):
            raise ValueError("the handler of a signal must be callable")
        before = self.__handlers.pop(signum, None)
        if handler is not None:
            self.__handlers[signum] = handler
        return before

    def __enter__(self) -> AsyncSafeSignalManager:
        reader, writer = socket.socketpair()
        reader.setblocking(False)
        writer.setblocking(False)
        try:
            self.__before = signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
        except ValueError:
            reader.close()
            writer.close()
            raise
        self.__sockets = reader, writer
        self.__loop.add_reader(reader.fileno(), self.__deliver)
        return self

    def __exit__(self, *exc: object) -> None:
        assert self.__sockets is not None
        signal.set_wakeup_fd(self.__before)
        reader, writer = self.__sockets
        self.__sockets = None
        self.__loop.remove_reader(reader.fileno())
        reader.close()
        writer.close()

    def __deliver(self) -> None:
        assert self.__sockets is not None
        try:
            signums = self.__sockets[0].recv(4096)
        except BlockingIOError:
            return
        if self.__before >= 0:
            os.write(self.__before, signums)  # an outer manager, or asyncio itself
        for signum in signums:
            handler = self.__handlers.get(signum)
            if handler is not None:
                handler(signum)
