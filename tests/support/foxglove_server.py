"""`foxglove` as a program."""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping

from tests.support.verbs import TIMEOUT_S
from tests.support.waiting import rest_of


class Server:
    """A running `foxglove` and what it has printed."""

    def __init__(self, env: Mapping[str, str], *words: str) -> None:
        command = [sys.executable, "-m", "launcher", "foxglove", "--port", "0", "--json", *words]
        self.process = subprocess.Popen(
            command, env=dict(env), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        self.events = []
        for line in self.process.stdout:
            if line.startswith("{"):  # Fast DDS may complain of a port
                self.events.append(json.loads(line))
                break
        self.url = self.events[0]["url"]

    def end(self) -> tuple[str, str]:
        """Ctrl-C; what it printed after the start, on both streams."""
        self.process.send_signal(signal.SIGINT)
        return rest_of(self.process, TIMEOUT_S)


@contextlib.contextmanager
def serving(env: Mapping[str, str], *words: str) -> Iterator[Server]:
    server = Server(env, *words)
    try:
        yield server
    finally:
        if server.process.poll() is None:
            server.end()
