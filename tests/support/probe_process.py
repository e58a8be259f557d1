"""The probe as a process, and all its output."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from typing import Any

from tests.support.node_process import without_complaints
from tests.support.repository import REPOSITORY
from tests.support.waiting import wait_until


class ProbeProcess:
    """Sends requests and keeps the lines that come. Use `with`: it ends by its input."""

    def __init__(self, env: Mapping[str, str], *, reads: bool = True) -> None:
        self.said: list[dict[str, Any]] = []
        self._numbers = itertools.count(1)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "launcher.ros.probe"],
            env=dict(env),
            cwd=REPOSITORY,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        if reads:
            self.begin_to_read()

    def begin_to_read(self) -> None:
        self._reader.start()

    def __enter__(self) -> ProbeProcess:
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        if not self._reader.is_alive():
            self._process.kill()  # nobody reads its last answers
        ended = self.end()
        if error is None:
            assert ended == (0, "")

    @property
    def pid(self) -> int:
        return self._process.pid

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.said.append(json.loads(line))

    def send_line(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(line.encode() + b"\n")
        self._process.stdin.flush()

    def send(self, do: str, **fields: Any) -> int:
        """Send a request and do not wait; its number."""
        number = next(self._numbers)
        self.send_line(json.dumps({"id": number, "do": do, **fields}))
        return number

    def answer(self, number: Any) -> dict[str, Any]:
        """The answer to a request, as soon as it has come."""
        return self.wait_for(lambda x: "event" not in x and x["id"] == number, f"answer {number}")

    def ask(self, do: str, **fields: Any) -> dict[str, Any]:
        """The result of a request that must succeed."""
        answer = self.answer(self.send(do, **fields))
        assert answer["ok"], answer
        return dict(answer["result"])

    def refusal(self, do: str, **fields: Any) -> dict[str, Any]:
        """The error of a request that must not succeed."""
        answer = self.answer(self.send(do, **fields))
        assert not answer["ok"], answer
        return dict(answer["error"])

    def wait_for(self, fact: Callable[[dict[str, Any]], object], what: str) -> dict[str, Any]:
        """The first line for which the fact holds."""

        def found() -> dict[str, Any] | None:
            return next(filter(fact, list(self.said)), None)

        wait_until(found, what)
        line = found()
        assert line is not None
        return line

    def event(self, name: str, **fields: Any) -> dict[str, Any]:
        """The first event of this name with these fields."""
        wanted = {"event": name, **fields}
        return self.wait_for(lambda x: wanted.items() <= x.items(), f"{name} {fields}")

    def messages(self, sub: str) -> list[Any]:
        """The contents of the messages so far."""
        wanted = {"event": "message", "sub": sub}
        return [line["data"] for line in list(self.said) if wanted.items() <= line.items()]

    def graph(self, fact: Callable[[dict[str, Any]], object], what: str) -> dict[str, Any]:
        """The first graph for which the fact holds."""
        return self.wait_for(lambda x: x.get("event") == "graph" and fact(x), what)

    def signal(self, signum: int) -> None:
        self._process.send_signal(signum)

    def end(self) -> tuple[int, str]:
        """Close its input; the exit code and what it wrote to stderr."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        return self.wait()

    def wait(self) -> tuple[int, str]:
        code = self._process.wait(60)
        assert self._process.stderr is not None
        return code, without_complaints(self._process.stderr.read().decode())


def names(graph: Mapping[str, Any]) -> set[str]:
    """The nodes of a graph that live."""
    return {node["name"] for node in graph["nodes"] if not node["ghost"]}
