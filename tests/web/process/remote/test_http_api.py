"""The page's server for programs: the API, its description, MCP, and who may ask."""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import urlsplit

import pytest

from tests.support.children import children_with, is_alive
from tests.support.controlled_run import ControlledRun
from tests.support.mcp_client import mcp_error
from tests.support.waiting import wait_until
from tests.support.web_page import cookie_of, key_of, run_with_page, server_of

if TYPE_CHECKING:
    from mcp.client import Client

JSON = {"Content-Type": "application/json"}


class Answer(NamedTuple):
    """What the server has answered; `body` is None unless it is JSON."""

    status: int
    body: Any
    headers: dict[str, str]


class Page:
    """A run and its page's server."""

    def __init__(self, run: ControlledRun, link: str) -> None:
        self.run, self.link = run, link
        self.address = "{0.scheme}://{0.netloc}".format(urlsplit(link))
        self.bearer = {"Authorization": f"Bearer {link.partition('token=')[2]}"}

    def ask(self, method: str, path: str, body: str | None = None, **headers: str | None) -> Answer:
        """An answer to a request with the token; a header that is None is left out."""
        fields = {**self.bearer, **(JSON if body is not None else {})}
        fields |= {name.replace("_", "-"): value for name, value in headers.items()}
        parts = urlsplit(self.link)
        connection = http.client.HTTPConnection(parts.hostname or "", parts.port, timeout=60)
        with contextlib.closing(connection):
            sent = {name: value for name, value in fields.items() if value is not None}
            connection.request(method, path, body, sent)
            found = connection.getresponse()
            text = found.read()
            kind = found.getheader("content-type", "")
            is_json = kind.startswith("application/json")
            document = json.loads(text) if is_json else None
            return Answer(found.status, document, {k.lower(): v for k, v in found.getheaders()})

    def waiting(self) -> tuple[http.client.HTTPConnection, int]:
        """A connection whose request is being carried out, and the command for that."""
        parts = urlsplit(self.link)
        connection = http.client.HTTPConnection(parts.hostname or "", parts.port, timeout=60)
        connection.request("GET", "/api/wait?topics=/never", headers=self.bearer)
        server = server_of(self.run.process.pid)
        assert server is not None
        wait_until(lambda: children_with(server, "guard.py"), "the guard of the command")
        (guard,) = children_with(server, "guard.py")
        wait_until(lambda: children_with(guard.pid, "wait"), "the command that waits")
        return connection, children_with(guard.pid, "wait")[0].pid

    def post(self, verb: str, **arguments: Any) -> Answer:
        return self.ask("POST", f"/api/{verb}", json.dumps(arguments))

    def get(self, path: str) -> Answer:
        return self.ask("GET", path)


@contextlib.contextmanager
def page_of(folder: Path, *words: str) -> Iterator[Page]:
    file = folder / "cat.launch.xml"
    file.write_text('<launch><executable name="cat" cmd="cat" output="screen"/></launch>')
    with tempfile.TemporaryDirectory(prefix="run-") as runtime:
        environment = {**os.environ, "ROS_LOG_DIR": f"{runtime}/log"}
        screen = folder / "screen"
        with run_with_page(file, words, environment, Path(runtime), screen) as (run, link):
            yield Page(run, link)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """Of a run whose process goes on."""
    with page_of(tmp_path_factory.mktemp("page")) as found:
        yield found


@pytest.fixture(scope="module")
def reading_page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """Of a run that a page may not control."""
    with page_of(tmp_path_factory.mktemp("page"), "--web-read-only") as found:
        yield found


def test_a_program_looks_at_a_run_and_controls_it(page: Page):
    assert page.post("wait", names=["cat"], timeout=50).body["result"]["holds"] is True
    status, body, headers = page.get("/api/ps")
    assert (status, headers["cache-control"]) == (200, "no-store")
    assert [one["name"] for one in body["result"]["processes"]] == ["cat-1"]
    assert page.post("send", names=["cat"], text="hello").status == 200
    page.run.wait_for_log("cat", "hello")
    logs = page.get("/api/logs?names=cat&limit=1").body
    assert [line["text"] for line in logs["result"]["lines"]] == ["hello"]
    assert logs["text"] == ["[cat-1] hello"]
    before = page.run.row("cat")["pid"]
    assert page.post("restart", names=["cat"]).status == 200
    assert page.run.row("cat")["pid"] not in (before, None)
    events = page.post("events", limit=1).body["result"]
    assert len(events["events"]) == 1 and events["omitted"] > 0


@pytest.mark.parametrize(
    ("method", "path", "body", "status", "code"),
    [
        ("POST", "/api/stop", '{"names": ["dog"]}', 404, "unknown-name"),
        ("POST", "/api/start", '{"names": ["cat"]}', 409, "wrong-state"),
        ("POST", "/api/stop", "{}", 400, "bad-request"),
        ("POST", "/api/stop", "[1]", 400, "bad-request"),
        ("POST", "/api/stop", "{", 400, "bad-request"),
        ("POST", "/api/logs", '{"limit": -1}', 400, "bad-option"),
        ("GET", "/api/logs?limit=many", None, 400, "bad-option"),
        ("GET", "/api/logs?follow=true", None, 400, "bad-option"),
        ("POST", "/api/kill", '{"names": ["cat"], "signal": "X"}', 400, "bad-option"),
        ("POST", "/api/nothing", "{}", 404, "unknown-verb"),
        ("POST", "/api/detach", "{}", 404, "unknown-verb"),
        ("POST", "/api/runs", "{}", 404, "unknown-verb"),
        ("POST", "/api/ps", '{"run": "1"}', 400, "bad-option"),
        ("GET", "/api/stop?names=cat", None, 405, "bad-request"),
        ("PUT", "/api/ps", "{}", 405, "bad-request"),
        ("GET", "/api/faults?mute=x", None, 405, "bad-request"),
        ("GET", "/api/faults", None, 409, "wrong-state"),  # the run is not watched
        ("POST", "/api/ps", "x" * 70_000, 413, "bad-request"),
        ("GET", "/api/wait?topics=/none&timeout=0.1", None, 504, "timeout"),
    ],
)
def test_errors_have_a_status_and_the_code_of_the_control_socket(
    page: Page, method: str, path: str, body: str | None, status: int, code: str
):
    found = page.ask(method, path, body)

    assert (found.status, found.body["error"]["code"]) == (status, code)
    assert found.body["error"]["message"]


def test_only_who_has_the_token_is_answered(page: Page):
    cookie, key = cookie_of(page.link), key_of(page.link)
    token = page.bearer["Authorization"].partition(" ")[2]
    for path in ("/api/ps", "/openapi.json", "/mcp", "/api/nothing"):
        for wrong in (None, "Bearer ", f"Bearer {token}x", f"Basic {token}"):
            for sent in (None, cookie):  # a browser sends it to other ports of this host, too
                found = page.ask("GET", path, Authorization=wrong, Cookie=sent)
                assert (found.status, found.headers["www-authenticate"]) == (401, "Bearer"), path
                assert "missing or wrong" in found.body["error"]["message"]
        for name in ("evil.example", "127.0.0.1.evil.example", ""):
            assert page.ask("GET", path, Host=name).status in (400, 403), path
        for origin in ("http://evil.example", "null", "http://127.0.0.1:1"):
            assert page.ask("GET", path, Origin=origin).status == 403, path
    assert page.ask("GET", "/api/ps", Origin=page.address).status == 200
    assert page.ask("GET", f"/api/ps?token={token}", Authorization=None).status == 200
    both = {"Cookie": cookie, "feed_key": key}
    assert page.ask("GET", "/api/ps", Authorization=None, **both).status == 200
    other = page.ask("POST", "/api/ps", "{}", Content_Type="text/plain")
    assert other.status == 415


def test_the_description_names_what_is_served(page: Page):
    document = page.get("/openapi.json").body

    assert document["openapi"].startswith("3.1")
    stop, logs = document["paths"]["/api/stop"], document["paths"]["/api/logs"]
    assert "get" not in stop
    body = stop["post"]["requestBody"]
    assert body["required"] and body["content"]["application/json"]["schema"]["required"]
    assert {one["name"] for one in logs["get"]["parameters"]} == {"names", "limit"}
    names = [one["operationId"] for each in document["paths"].values() for one in each.values()]
    assert len(names) == len({*names})


def test_a_page_that_only_shows_serves_only_what_reads(reading_page: Page):
    assert reading_page.get("/api/ps").status == 200
    assert not {"/api/stop", "/api/quit"} & reading_page.get("/openapi.json").body["paths"].keys()
    for verb in ("stop", "kill", "send", "quit", "reload", "loglevel"):
        found = reading_page.post(verb, names=["cat"])
        assert (found.status, found.body["error"]["code"]) == (403, "read-only")
    address = "/api/faults?mute=x"
    for found in (reading_page.post("faults", mute="x"), reading_page.get(address)):
        assert (found.status, found.body["error"]["code"]) == (403, "read-only")
    assert reading_page.run.row("cat")["pid"] is not None

    async def use(client: Client) -> None:
        assert "stop" not in {tool.name for tool in (await client.list_tools()).tools}
        with pytest.raises(mcp_error(), match="'stop' changes something"):
            await client.call_tool("stop", {"names": ["cat"]})
        with pytest.raises(mcp_error(), match="'faults' with 'mute' changes something"):
            await client.call_tool("faults", {"mute": "x"})

    by_mcp(reading_page, use)


def by_mcp(page: Page, use: Any, mode: str = "auto", **headers: str) -> None:
    """Let `use` have the SDK's client of `/mcp`."""
    import httpx2
    from mcp.client import Client
    from mcp.client.streamable_http import streamable_http_client

    async def serve() -> None:
        fields = {**page.bearer, **headers}
        async with (
            httpx2.AsyncClient(headers=fields) as sender,
            Client(
                streamable_http_client(f"{page.address}/mcp", http_client=sender), mode=mode
            ) as client,
        ):
            await use(client)

    asyncio.run(asyncio.wait_for(serve(), 60))


@pytest.mark.parametrize("mode", ["auto", "legacy"])
def test_an_mcp_client_uses_the_page_s_server(page: Page, mode: str):
    async def use(client: Client) -> None:
        tools = {tool.name for tool in (await client.list_tools()).tools}
        assert {"ps", "stop", "graph"} <= tools and "runs" not in tools
        found = await client.call_tool("ps", {"names": ["cat"]})
        assert found.structured_content["processes"][0]["name"] == "cat-1"
        wrong = await client.call_tool("start", {"names": ["dog"]})
        assert wrong.is_error and wrong.structured_content["error"]["code"] == "unknown-name"

    by_mcp(page, use, mode)


def test_a_call_ends_with_its_client(page: Page):
    connection, command = page.waiting()

    connection.close()

    wait_until(lambda: not is_alive(command), "its end")


@pytest.mark.thorough
def test_the_end_of_the_run_ends_open_calls(tmp_path: Path):
    with page_of(tmp_path) as page:
        connection, command = page.waiting()

        assert page.post("quit").status == 200

        assert page.run.exit_code() == 0
        wait_until(lambda: not is_alive(command), "its end")
        connection.close()


def test_the_page_s_server_imports_nothing_of_this_before_a_program_asks():
    code = "import sys, launcher.web.web_server; print(*sys.modules)"
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()

    assert not [name for name in found if name.startswith(("launcher.web.remote", "mcp"))]
