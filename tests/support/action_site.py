"""A domain with an action server, and verbs in the workspace of its type."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from tests.support.verbs import Answer, going_on, launcher

TYPE = "fleet_interfaces/action/ExecuteTask"
WAIT = "assignment: {task: wait}"


class Site:
    """A domain with an action server, and a launcher in the workspace of its type."""

    def __init__(self, env: dict[str, str], root: Path) -> None:
        self.env = env
        self.root = root

    def action(self, *words: str, text: str | None = None) -> Answer:
        return launcher(self.env, "action", *words, text=text, cwd=self.root)

    def graph(self, *words: str) -> Answer:
        """What a verb about actions reads from the graph, however long it takes to be complete."""
        return self.action(*words, "--spin-time", "60")

    def topic(self, *words: str) -> Answer:
        return launcher(self.env, "topic", *words, cwd=self.root)

    def call(self, *words: str) -> Answer:
        return launcher(self.env, "service", "call", *words, cwd=self.root)

    def send_goal(self, goal: str, *words: str) -> Answer:
        return self.action("send_goal", "/execute", TYPE, goal, *words)

    def going_on(self, *words: str) -> contextlib.AbstractContextManager[subprocess.Popen[str]]:
        return going_on(self.env, *words, cwd=self.root)

    @contextlib.contextmanager
    def pursuing(
        self, *options: str, in_background: bool = False
    ) -> Iterator[subprocess.Popen[str]]:
        """`send_goal` whose goal the server executes until it is cancelled.

        `in_background`: as a script starts it with `&`, with SIGINT ignored.
        """
        words = ("action", "send_goal", "/execute", TYPE, WAIT, *options)
        program = subprocess.Popen(
            [sys.executable, "-m", "launcher", *words],
            env=self.env,
            cwd=self.root,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_IGN)
            if in_background
            else None,
        )
        with program:
            try:
                yield program
            finally:
                if program.poll() is None:
                    program.send_signal(signal.SIGINT)
                    program.communicate(timeout=60)
