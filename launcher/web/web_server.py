"""The process that serves the page of a run: it listens until the run ends."""

from __future__ import annotations

import asyncio
import contextlib
import dataclasses
import errno
import socket
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote, urlsplit

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from launcher.base import strict_json
from launcher.base.errors import LauncherError
from launcher.control.protocol import node_variables
from launcher.posix import dispositions
from launcher.web.access import Access, is_loopback, new_token, token_in
from launcher.web.graph_feed import GraphFeed
from launcher.web.hub import Hub
from launcher.web.page_session import Feeds
from launcher.web.run_feed import RunFeed
from launcher.web.site import Site

DEFAULT_HOST = "127.0.0.1"
DEFAULT_PORT = 8770
_REQUEST_S = 10.0  # for a whole request to come
_GOODBYE_S = 1.0  # for pages to read that the run has ended
_REQUEST_BYTES = 1024 * 1024


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class PageSettings:
    """Options of the verb, or JSON from the launcher. `socket`: of the run.

    `port` None: the default one, or any if that is taken. The token is that of `token_file`,
    `token`, or a new one. `certificate` and `key` are files in PEM.
    """

    socket: str
    host: str = DEFAULT_HOST
    port: int | None = None
    token_file: str | None = None
    token: str | None = None
    certificate: str | None = None
    key: str | None = None
    read_only: bool = False

    @classmethod
    def from_json(cls, text: str) -> PageSettings:
        values: dict[str, Any] = strict_json.unpacked(text)
        return cls(**values)


class WebServer:
    """Serves the page of a run until the run ends or `stop` is called."""

    def __init__(self, settings: PageSettings) -> None:
        self._settings = settings
        self._token = settings.token or new_token()
        if settings.token_file is not None:
            self._token = token_in(settings.token_file)
        self._scheme = "http" if settings.certificate is None else "https"
        self._hub = Hub(lambda: self._graph.subscribe(), self._fail)
        self._end = asyncio.Event()
        self._failure: BaseException | None = None
        self._run = RunFeed(self._hub, self._end.set)
        self._graph = GraphFeed(self._hub, lambda: self._run.rows)
        feeds = Feeds(self._hub, self._run, self._graph, read_only=settings.read_only)
        access = Access(self._token, settings.host, secure=settings.certificate is not None)
        self._site = Site(access, feeds, Path(settings.socket))

    async def serve(self, on_link: Callable[[str], None]) -> None:
        """Call `on_link` with the link when it works; LauncherError if it cannot.

        What ends the work for all pages is raised.
        """
        await self._run.start(Path(self._settings.socket))
        self._graph.environment = node_variables(self._run.run)
        listening = _listen(self._settings)
        config = uvicorn.Config(
            self._site.application(),
            log_config=None,
            access_log=False,
            lifespan="off",
            http=_Http,
            server_header=False,
            ws="websockets-sansio",
            ws_max_size=_REQUEST_BYTES,
            ws_per_message_deflate=False,
            timeout_graceful_shutdown=1,
            ssl_certfile=self._settings.certificate,
            ssl_keyfile=self._settings.key,
        )
        server = _Server(config)
        serving = asyncio.create_task(server.serve(sockets=[listening]))
        on_link(self._link(listening))
        ending = asyncio.create_task(self._end.wait())
        try:
            await asyncio.wait({serving, ending}, return_when=asyncio.FIRST_COMPLETED)
            if self.has_ended and len(self._hub):
                await asyncio.sleep(_GOODBYE_S)
        finally:
            ending.cancel()
            await self._site.close()
            server.should_exit = True
            with contextlib.suppress(asyncio.CancelledError):
                await serving
            await self._graph.close()
            await self._run.close()
        if self._failure is not None:
            raise self._failure

    @property
    def has_ended(self) -> bool:
        """Whether the run has ended."""
        return self._run.ended is not None

    def stop(self) -> None:
        """End `serve`."""
        self._end.set()

    def _fail(self, error: BaseException) -> None:
        """End `serve` with this error: pages see the end, and connect to the next server."""
        self._failure = self._failure or error
        self._end.set()

    def end_run(self) -> None:
        """The run has ended in order: report that to the pages, and end `serve`."""
        self._run.end("ended")

    def _link(self, listening: socket.socket) -> str:
        port = listening.getsockname()[1]
        host = self._settings.host
        if host in ("0.0.0.0", "::"):
            host = socket.gethostname()
        shown = f"[{host}]" if ":" in host else host
        return f"{self._scheme}://{shown}:{port}/?token={quote(self._token, safe='')}"


class _Http(H11Protocol):
    """Closes connections that send no whole request: many of them would lock the page out.

    It looks whether there has been one since it looked last, so that bytes that come slowly do not
    keep a connection open. An answer that is being read does.
    """

    request_s = _REQUEST_S

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        asyncio.get_running_loop().call_later(self.request_s, self._close_if_idle, None)

    def _close_if_idle(self, before: object) -> None:
        is_websocket = self.transport.get_protocol() is not self
        if is_websocket or self.transport.is_closing():
            return
        if self.cycle is before and (self.cycle is None or self.cycle.response_complete):
            self.transport.close()
            return
        loop = asyncio.get_running_loop()
        loop.call_later(self.request_s, self._close_if_idle, self.cycle)


class _Server(uvicorn.Server):
    """Leaves the handlers of signals alone."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


def risk(settings: PageSettings) -> str | None:
    """What is risked by these settings, for the terminal."""
    if is_loopback(settings.host) or settings.certificate is not None:
        return None
    return (
        f"the page listens on {settings.host} without encryption: who can read the network can "
        "read the token and control this run (--web-tls CERT,KEY encrypts it)"
    )


def _listen(settings: PageSettings) -> socket.socket:
    """A listening socket; the default port is replaced by a free one if it is taken."""
    port = DEFAULT_PORT if settings.port is None else settings.port
    try:
        return _bound(settings.host, port)
    except OSError as error:
        if error.errno == errno.EADDRINUSE and settings.port is None:
            return _bound(settings.host, 0)
        raise LauncherError(
            f"cannot listen on {settings.host} port {port}: {error.strerror or error}",
            hint="another port: --web-port N" if error.errno == errno.EADDRINUSE else None,
        ) from None


def _bound(host: str, port: int) -> socket.socket:
    family, kind, number, _, address = socket.getaddrinfo(
        host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )[0]
    listening = socket.socket(family, kind, number)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind(address)
        listening.listen(128)
    except OSError:
        listening.close()
        raise
    return listening


def main() -> None:
    """`python -m launcher.web.web_server`, by --web: lines of JSON in both directions.

    The first line of the input is `PageSettings`; `end` says that the run has ended in order, the
    end of the input that the launcher has. The output is `{"link": URL, "port": N, "token": TEXT}`
    when the page works, `{"warning": TEXT}`, or `{"error": TEXT}`.
    """
    dispositions.ignore()  # the run decides when it ends
    settings = PageSettings.from_json(sys.stdin.readline())
    try:
        asyncio.run(_serve_for_launcher(settings))
    except LauncherError as error:
        print(strict_json.packed({"error": error.message}), flush=True)
        sys.exit(error.message)


async def _serve_for_launcher(settings: PageSettings) -> None:
    server = WebServer(settings)
    reader = asyncio.create_task(_watch_input(server))
    if warning := risk(settings):
        print(strict_json.packed({"warning": warning}), flush=True)
    await server.serve(_print_link)
    reader.cancel()


def _print_link(link: str) -> None:
    """With what the launcher gives a server that replaces this one."""
    parts = urlsplit(link)
    token = unquote(parts.query.removeprefix("token="))
    print(strict_json.packed({"link": link, "port": parts.port, "token": token}), flush=True)


async def _watch_input(server: WebServer) -> None:
    loop = asyncio.get_running_loop()
    reader = asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    while line := await reader.readline():
        if line.strip() == b"end":
            server.end_run()
            return
    await asyncio.sleep(_GOODBYE_S)  # the end of the control socket says how the launcher ended
    server.stop()


if __name__ == "__main__":
    main()
