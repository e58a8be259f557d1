"""The tools over HTTP: `/openapi.json`, `/api/VERB` and `/mcp`. Who may ask is decided before."""

from __future__ import annotations

import asyncio
import importlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from starlette.requests import Request
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from launcher.base import strict_json
from launcher.base.run_verb import BadCallError
from launcher.control.protocol import REQUEST_LIMIT
from launcher.packages.extras import install_command, is_installed
from launcher.web.remote import openapi
from launcher.web.remote.tool import Tool
from launcher.web.remote.toolbox import Toolbox

if TYPE_CHECKING:
    from launcher.web.remote.mcp_endpoint import McpEndpoint

_ENDPOINT = "launcher.web.remote.mcp_endpoint"
TOKEN = "token"  # a parameter of addresses that is no argument
_HEADERS = {"Cache-Control": "no-store", "X-Content-Type-Options": "nosniff"}
# The HTTP status for the code of an error.
STATUS = {
    "bad-request": 400,
    "bad-option": 400,
    "bad-launch-file": 400,
    "read-only": 403,
    "unknown-verb": 404,
    "unknown-name": 404,
    "ambiguous-name": 409,
    "wrong-state": 409,
    "failed": 409,
    "stopping": 503,
    "refused": 503,
    "no-run": 503,
    "unknown-run": 503,
    "timeout": 504,
}
_INTERNAL, _NO_METHOD, _TOO_LARGE, _NO_JSON, _ABSENT = 500, 405, 413, 415, 501


class HttpApi:
    """Answers requests about the run that listens at `socket`."""

    def __init__(self, socket: Path, *, read_only: bool) -> None:
        self._toolbox = Toolbox(socket=socket, read_only=read_only)
        self._mcp: McpEndpoint | None = None
        self._starting = asyncio.Lock()
        self._is_closed = False

    async def describe(self, request: Request) -> Response:
        """`/openapi.json`."""
        return _json(openapi.document(self._toolbox.tools.values()))

    async def call(self, request: Request) -> Response:
        """`/api/VERB`: the arguments are a JSON object, or with GET the query."""
        name = request.path_params["verb"]
        try:
            given = await self._arguments(request, name)
            outcome = await self._carried_out(request, name, given)
        except _Refused as error:
            return error.response
        except BadCallError as error:
            return _problem(error, STATUS.get(error.code, _INTERNAL))
        return _json({"result": outcome.result, "text": outcome.text})

    async def _arguments(self, request: Request, name: str) -> Mapping[str, Any]:
        tool = self._toolbox.tool(name)
        reading = tool.only_reading
        if request.method in ("GET", "HEAD") and reading is not None:
            refused = sorted({*tool.changing} & {*request.query_params})
            if tool.is_read_only or not refused:
                return _from_query(reading, request)
            raise _Refused(_NO_METHOD, f"'{name}' with '{refused[0]}' takes POST", Allow="POST")
        if request.method != "POST":
            allowed = "POST" if reading is None else "GET, HEAD, POST"
            raise _Refused(_NO_METHOD, f"'{name}' takes {allowed}", Allow=allowed)
        return await _from_body(request)

    async def _carried_out(self, request: Request, name: str, given: Mapping[str, Any]) -> Any:
        """The outcome; the call ends if the client goes."""
        calling = asyncio.create_task(self._toolbox.call(name, given))
        leaving = asyncio.create_task(_left(request))
        try:
            await asyncio.wait({calling, leaving}, return_when=asyncio.FIRST_COMPLETED)
            if not calling.done():
                raise _Refused(_INTERNAL, "the client has gone")
            return calling.result()
        finally:
            calling.cancel()
            leaving.cancel()

    async def serve_mcp(self, scope: Scope, receive: Receive, send: Send) -> None:
        """`/mcp`, by the transport "streamable HTTP"."""
        if not is_installed("mcp"):
            error = BadCallError(
                "failed", "the Python package 'mcp' is not installed", install_command("mcp")
            )
            await _problem(error, _ABSENT)(scope, receive, send)
            return
        if self._is_closed:
            error = BadCallError("no-run", "the run has ended")
            await _problem(error, STATUS[error.code])(scope, receive, send)
            return
        async with self._starting:
            if self._mcp is None:  # half a second for the package, in which pages are served
                module = await asyncio.to_thread(importlib.import_module, _ENDPOINT)
                self._mcp = module.McpEndpoint(self._toolbox)
        await self._mcp.serve(scope, receive, send)

    async def close(self) -> None:
        """End what is open."""
        self._is_closed = True
        if self._mcp is not None:
            await self._mcp.close()
        await self._toolbox.close()


class _Refused(Exception):
    def __init__(self, status: int, message: str, **headers: str) -> None:
        super().__init__(message)
        self.response = _problem(BadCallError("bad-request", message), status, headers)


def refusal(status: int, message: str) -> Response:
    """The answer to who may not ask."""
    headers = {"WWW-Authenticate": "Bearer"} if status == 401 else {}
    return _problem(BadCallError("refused", message), status, headers)


def _problem(
    error: BadCallError, status: int, headers: Mapping[str, str] | None = None
) -> Response:
    return _json({"error": error.document}, status, headers)


def _json(
    document: Mapping[str, Any], status: int = 200, headers: Mapping[str, str] | None = None
) -> Response:
    body = strict_json.dumps(document, ensure_ascii=False) + "\n"
    return Response(
        body.encode(), status, {**_HEADERS, **(headers or {})}, media_type="application/json"
    )


def _from_query(tool: Tool, request: Request) -> dict[str, Any]:
    words: dict[str, list[str]] = {}
    for name, word in request.query_params.multi_items():
        if name != TOKEN:
            words.setdefault(name, []).append(word)
    known = {one.name: one for one in tool.arguments}
    tool.refuse_unknown(words)
    return {name: known[name].from_words(found, tool.name) for name, found in words.items()}


async def _from_body(request: Request) -> Mapping[str, Any]:
    body = b""
    async for chunk in request.stream():
        body += chunk
        if len(body) > REQUEST_LIMIT:
            raise _Refused(_TOO_LARGE, f"a request has at most {REQUEST_LIMIT} bytes")
    if not body:
        return {}
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind != "application/json":
        raise _Refused(_NO_JSON, "the Content-Type of a request is application/json")
    try:
        found = strict_json.loads(body)
    except ValueError as error:
        raise BadCallError("bad-request", f"a request is a JSON object: {error}") from None
    if not isinstance(found, dict):
        raise BadCallError("bad-request", "a request is a JSON object")
    return found


async def _left(request: Request) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass
