"""The WebSocket server: from the first connection to Ctrl-C."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import logging
import signal
import socket
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from launcher.base.errors import ExitCode
from launcher.base.ros_errors import VerbError
from launcher.posix.dispositions import heeded
from launcher.posix.json_output import print_line
from launcher.ros.verb import GraphAccess, observing, warn

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.foxglove.foxglove_bridge import FoxgloveBridge
    from launcher.ros.foxglove.graph_view import TopicChoice

_MOST_MESSAGE_BYTES = 64 * 1024 * 1024  # of one message of a client
_OPEN_S = 10.0  # for the handshake of a client
_CLOSE_S = 1.0  # for the good-bye of a client
_LOOPBACK = ("127.0.0.1", "::1", "localhost")
# A client that has vanished without a good-bye is noticed after 30 s.
_KEEP_ALIVE = {"TCP_KEEPIDLE": 15, "TCP_KEEPINTVL": 5, "TCP_KEEPCNT": 3}


@dataclass(frozen=True, slots=True, kw_only=True)
class ServerOptions:
    """What `foxglove` was asked for; `most_bytes` may wait for one client."""

    choice: TopicChoice
    host: str
    port: int
    most_bytes: int
    read_only: bool
    json: bool


def serve(access: GraphAccess, options: ServerOptions) -> int:
    """Serve until Ctrl-C or SIGTERM; VerbError if that is not possible."""
    options.choice.check()
    with observing(access) as observer:
        asyncio.run(_serve(observer, options))
    return ExitCode.OK


async def _serve(observer: Observer, options: ServerOptions) -> None:
    from launcher.ros.foxglove.foxglove_bridge import FoxgloveBridge

    def report(event: str, **fields: object) -> None:
        if options.json:
            print_line({"event": event, **fields})
        else:
            print(_line(event, fields), flush=True)

    stop = asyncio.Event()
    for signum in heeded((signal.SIGINT, signal.SIGTERM, signal.SIGHUP)):
        asyncio.get_running_loop().add_signal_handler(signum, stop.set)
    bridge = FoxgloveBridge(
        observer,
        options.choice,
        report,
        most_bytes=options.most_bytes,
        is_read_only=options.read_only,
    )
    try:
        async with _listening(bridge, options.host, options.port) as port:
            report("listening", url=_url(options.host, port), domain_id=observer.domain_id)
            if options.host not in _LOOPBACK and not options.read_only:
                warn(
                    "warning: whoever reaches this address can publish, call services and set "
                    "parameters (--read-only forbids it)"
                )
            await _until_stopped(bridge, stop)
    finally:
        await bridge.close()


async def _until_stopped(bridge: FoxgloveBridge, stop: asyncio.Event) -> None:
    tasks = [asyncio.create_task(bridge.watch()), asyncio.create_task(stop.wait())]
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            task.result()  # raises what ended the watch
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


@contextlib.asynccontextmanager
async def _listening(bridge: FoxgloveBridge, host: str, port: int) -> AsyncIterator[int]:
    """The port that clients connect to; VerbError."""
    from websockets.asyncio.server import serve as websocket_server
    from websockets.typing import Subprotocol

    from launcher.ros.foxglove.protocol import SUBPROTOCOLS

    logger = logging.getLogger(__name__)
    logger.addHandler(logging.NullHandler())  # handshakes that fail are the client's business
    logger.propagate = False
    try:
        server = await websocket_server(
            bridge.serve,
            host,
            port,
            subprotocols=[Subprotocol(name) for name in SUBPROTOCOLS],
            compression=None,
            max_size=_MOST_MESSAGE_BYTES,
            ping_interval=None,  # a client that reads slowly would answer too late
            open_timeout=_OPEN_S,
            close_timeout=_CLOSE_S,
            logger=logger,
        )
    except OSError as error:
        raise _cannot_listen(error, host, port) from None
    try:
        for one in server.sockets:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)  # clients inherit it
            for name, value in _KEEP_ALIVE.items():
                one.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
        yield next(iter(server.sockets)).getsockname()[1]
    finally:
        server.close()
        with contextlib.suppress(asyncio.TimeoutError):
            await asyncio.wait_for(server.wait_closed(), 2 * _CLOSE_S)


def _cannot_listen(error: OSError, host: str, port: int) -> VerbError:
    if error.errno == errno.EADDRINUSE:
        return VerbError(
            f"port {port} of {host} is in use",
            hint=f"another foxglove may be running; for another port: --port {port + 1}",
        )
    if isinstance(error, socket.gaierror):
        return VerbError(
            f"there is no address for the host '{host}'",
            hint="--host takes an address of this machine, or 0.0.0.0 for all of them",
        )
    reason = error.strerror or str(error)
    return VerbError(f"cannot listen on port {port} of {host}: {reason}")


def _url(host: str, port: int) -> str:
    name = socket.gethostname() if host in ("0.0.0.0", "::") else host
    return f"ws://[{name}]:{port}" if ":" in name else f"ws://{name}:{port}"


def _line(event: str, fields: dict[str, object]) -> str:
    if event == "listening":
        return f"listening on {fields['url']} (domain {fields['domain_id']})"
    return f"client {fields['client']} {event} ({fields['address']})"
