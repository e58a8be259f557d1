"""A run with a page, and clients of it: HTTP, and the messages of its WebSocket."""

from __future__ import annotations

import contextlib
import http.client
import json
import re
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import psutil
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from tests.support.children import children_with
from tests.support.controlled_run import ControlledRun
from tests.support.waiting import wait_until

_LINK = re.compile(r"page: (https?://\S+)")


@contextlib.contextmanager
def run_with_page(
    target: Path | str, words: Sequence[str], env: dict[str, str], runtime: Path, screen: Path
) -> Iterator[tuple[ControlledRun, str]]:
    """A run, with the link that it has printed."""
    command = [sys.executable, "-m", "launcher", str(target), "--no-console", "--web"]
    command += ["--web-port", "0", *words]
    with ControlledRun(command, env=env, runtime=runtime, screen=screen) as run:
        wait_until(lambda: _LINK.search(run.screen) or run.process.poll() is not None, "a link")
        found = _LINK.search(run.screen)
        assert found is not None, run.screen
        yield run, found[1]


def get(link: str, path: str = "", **headers: str) -> tuple[int, dict[str, str], str]:
    """(status, headers, text) of a GET; names of headers with _ for -."""
    parts = urlsplit(link)
    connection = http.client.HTTPConnection(parts.hostname or "", parts.port, timeout=30)
    with contextlib.closing(connection):
        fields = {name.replace("_", "-"): value for name, value in headers.items()}
        connection.putrequest("GET", path or f"/?{parts.query}", skip_host="Host" in fields)
        for name, value in fields.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        text = answer.read().decode(errors="replace")
        return answer.status, {k.lower(): v for k, v in answer.getheaders()}, text


def cookie_of(link: str) -> str:
    """The cookie that the link gives."""
    status, headers, _ = get(link)
    assert status == 200
    return headers["set-cookie"].partition(";")[0]


def server_of(pid: int) -> int | None:
    """The process of the server that the launcher has started."""
    found = children_with(pid, "launcher.web.web_server")
    return found[0].pid if found else None


def key_of(link: str) -> str:
    """The key of the feed, which the page has with the link."""
    found = re.search(r'name="feed-key" content="([^"]+)"', get(link)[2])
    assert found is not None
    return found[1]


class PageClient:
    """What a page is to the server; a thread keeps what comes. Use `with`."""

    def __init__(self, link: str, **more: Any) -> None:
        parts = urlsplit(link)
        origin = f"{parts.scheme}://{parts.netloc}"
        headers = {"Cookie": cookie_of(link)}
        self.key = key_of(link)
        self.events: list[dict[str, Any]] = []
        self.answers: dict[int, dict[str, Any]] = {}
        self._number = 0
        self._stack = contextlib.ExitStack()
        self.socket: ClientConnection = self._stack.enter_context(
            connect(
                f"ws://{parts.netloc}/feed",
                origin=more.pop("origin", origin),
                additional_headers=headers,
                max_size=None,
                **more,
            )
        )
        threading.Thread(target=self._read, daemon=True).start()

    def __enter__(self) -> PageClient:
        return self

    def __exit__(self, *exc: object) -> None:
        self._stack.close()

    def _read(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            for text in self.socket:
                message = json.loads(text)
                if "event" in message:
                    self.events.append(message)
                else:
                    self.answers[message["id"]] = message

    def ask(self, do: str, **fields: Any) -> dict[str, Any]:
        """Send a request, and wait for its answer."""
        return self.answer(self.send(do, **fields))

    def send(self, do: str, **fields: Any) -> int:
        """Send a request; its number, for `answer`."""
        self._number += 1
        self.socket.send(json.dumps({"id": self._number, "do": do, **fields}))
        return self._number

    def answer(self, number: int) -> dict[str, Any]:
        """Wait for the answer to a request."""
        wait_until(lambda: number in self.answers, f"the answer to request {number}")
        return self.answers.pop(number)

    def of(self, event: str) -> list[dict[str, Any]]:
        """The messages of a kind that have come."""
        return [message for message in list(self.events) if message["event"] == event]

    def lines(self) -> list[list[Any]]:
        """All lines that have come: [process, stream, time, level, text]."""
        return [line for message in self.of("lines") for line in message["lines"]]

    def open(self) -> dict[str, Any]:
        """Ask for everything; the `hello`."""
        assert self.ask("open", key=self.key, after=None, server=None)["ok"]
        wait_until(lambda: self.of("hello"), "the hello")
        return self.of("hello")[-1]


def seconds_of_cpu(pid: int) -> float:
    """CPU time of a process so far."""
    used = psutil.Process(pid).cpu_times()
    return used.user + used.system
