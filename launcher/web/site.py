"""What the server answers: the page for who has the token, metrics, programs, the WebSocket."""

from __future__ import annotations

from base64 import b64encode
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from starlette.applications import Starlette
from starlette.requests import HTTPConnection, Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket

from launcher.web import assets
from launcher.web.access import Access
from launcher.web.page_session import NO_KEY, Doors, Feeds, PageSession

if TYPE_CHECKING:
    from launcher.web.remote.http_api import HttpApi

_METHODS = ("GET", "POST", "PUT", "PATCH", "DELETE")  # the API says itself which it takes
_KEY = "feed-key"  # a header: beside a cookie, which reaches other ports, too
_OTHER_HOST = "This host name is not one of this server's."


class _Asgi:
    """A method as an application: a `Route` takes functions and methods for endpoints."""

    def __init__(self, serve: ASGIApp) -> None:
        self._serve = serve

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        await self._serve(scope, receive, send)


class Site:
    """The application of an ASGI server."""

    def __init__(self, access: Access, feeds: Feeds, socket: Path) -> None:
        """`socket` is that of the run."""
        self._socket = socket
        self._api: HttpApi | None = None
        self._access = access
        self._feeds = feeds
        self._libraries = assets.libraries()
        self._own = assets.own_files()
        self._joined = assets.joined_files()
        self._policy = _content_policy()
        self._doors = Doors(access.is_feed_key)

    def application(self) -> Starlette:
        return Starlette(
            routes=[
                Route("/", self._index),
                Route("/page/{name:path}", self._own_file),
                Route("/lib/{name:path}", self._library),
                Route("/metrics", self._metrics),
                Route("/openapi.json", self._openapi),
                Route("/api/{verb}", self._call, methods=_METHODS),
                Route("/mcp", _Asgi(self._mcp)),
                WebSocketRoute("/feed", self._feed),
            ]
        )

    def _problem(self, request: HTTPConnection, *tokens: str | None) -> str | None:
        """Why a request is refused that brings these tokens, or only the cookie."""
        if not self._access.is_known_host(request.headers.get("host")):
            return _OTHER_HOST
        if any(map(self._access.is_token, tokens)) or self._access.has_cookie(request.cookies):
            return None
        return "Open the link that the launcher has printed: it contains the token."

    async def _index(self, request: Request) -> Response:
        given = request.query_params.get("token")
        problem = self._problem(request, given)
        if problem is not None:
            return _refused(problem)
        has_token = self._access.is_token(given)
        text = assets.index(self._access.feed_key if has_token else "")
        response = self._response(text.encode(), "text/html; charset=utf-8")
        if has_token:
            response.headers["Set-Cookie"] = self._access.cookie()
        return response

    async def _own_file(self, request: Request) -> Response:
        return self._file(request, self._own, self._joined)

    async def _library(self, request: Request) -> Response:
        return self._file(request, self._libraries, {})

    def _file(
        self, request: Request, files: dict[str, Path], joined: dict[str, tuple[bytes, str]]
    ) -> Response:
        problem = self._problem(request)
        if problem is not None:
            return _refused(problem)
        name = request.path_params["name"]
        if name in joined:
            return self._response(*joined[name])
        if name not in files:
            return PlainTextResponse("There is no such file.", 404)
        return self._response(*assets.content(files[name]))

    async def _metrics(self, request: Request) -> Response:
        from launcher.web.metrics import WATCH_S, Metrics

        if not self._access.is_known_host(request.headers.get("host")):
            return _refused(_OTHER_HOST)
        if not self._has_token(request):  # a cookie reaches other ports, too
            text = "The token is missing or wrong: use '?token=' or 'Authorization: Bearer'.\n"
            return PlainTextResponse(text, 401, {"WWW-Authenticate": "Bearer"})
        await self._feeds.graph.start()
        self._feeds.graph.watch_topics(WATCH_S)
        body, kind = Metrics(self._feeds.run, self._feeds.graph).text(
            request.headers.get("accept", "")
        )
        return Response(body, headers={"Content-Type": kind, "Cache-Control": "no-store"})

    def _has_token(self, request: HTTPConnection) -> bool:
        """Whether the token is in the address, or is that of `Authorization: Bearer`."""
        scheme, _, credentials = request.headers.get("authorization", "").partition(" ")
        bearer = credentials.strip() if scheme.lower() == "bearer" else None
        return any(map(self._access.is_token, (bearer, request.query_params.get("token"))))

    # ---- for programs

    def _refusal(self, request: HTTPConnection) -> Response | None:
        """The answer if the request is none of who has the token, or the page."""
        from launcher.web.remote.http_api import refusal

        host, origin = request.headers.get("host"), request.headers.get("origin")
        if not self._access.is_known_host(host):
            return refusal(403, _OTHER_HOST)
        if origin is not None and not self._access.is_same_origin(origin, host):
            return refusal(403, "This is a page of another site.")
        has_key = self._access.is_feed_key(request.headers.get(_KEY))
        if self._has_token(request) or (has_key and self._access.has_cookie(request.cookies)):
            return None
        return refusal(401, "The token is missing or wrong: use 'Authorization: Bearer'.")

    def _programs(self) -> HttpApi:
        if self._api is None:
            from launcher.web.remote.http_api import HttpApi

            self._api = HttpApi(self._socket, read_only=self._feeds.read_only)
        return self._api

    async def _openapi(self, request: Request) -> Response:
        return self._refusal(request) or await self._programs().describe(request)

    async def _call(self, request: Request) -> Response:
        return self._refusal(request) or await self._programs().call(request)

    async def _mcp(self, scope: Scope, receive: Receive, send: Send) -> None:
        answer = self._refusal(HTTPConnection(scope)) or self._programs().serve_mcp
        await answer(scope, receive, send)

    async def close(self) -> None:
        """End what programs have begun."""
        if self._api is not None:
            await self._api.close()

    # ---- the page

    def _response(self, body: bytes, kind: str) -> Response:
        headers = {
            "Content-Security-Policy": self._policy,
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "Cache-Control": "no-cache",
        }
        return Response(body, media_type=kind, headers=headers)

    async def _feed(self, socket: WebSocket) -> None:
        headers = socket.headers
        is_ours = self._access.is_same_origin(headers.get("origin"), headers.get("host"))
        if self._problem(socket) is not None or not is_ours:
            await socket.close(NO_KEY)
            return
        await socket.accept()
        session = PageSession(self._feeds, socket, self._doors)
        self._doors.arrive(session)
        try:
            await session.serve()
        finally:
            self._doors.leave(session)


def _refused(problem: str) -> Response:
    return PlainTextResponse(f"{problem}\n", 403)


def _content_policy() -> str:
    """The page's Content-Security-Policy. Vue compiles templates, hence 'unsafe-eval'."""
    digest = b64encode(sha256(assets.import_map().encode()).digest()).decode()
    return "; ".join(
        [
            "default-src 'none'",
            f"script-src 'self' 'unsafe-eval' 'sha256-{digest}'",
            "style-src 'self' 'unsafe-inline'",
            "font-src 'self'",
            "img-src 'self' data: blob:",
            "connect-src 'self'",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        ]
    )
