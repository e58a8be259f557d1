"""Fixtures of the end-to-end tests: the launcher's command line in a world of its own."""

from __future__ import annotations

import os
import sys
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path

import psutil
import pytest

from launcher.posix.domain_lease import leased_domain
from tests.support.repository import REPOSITORY
from tests.support.terminal import Terminal, marked_processes

MARK = "LAUNCHER_TEST_MARK"
# Nodes on a busy machine may take longer to end than they have as a rule.
LONG_STOP = {"sigterm_timeout": 60, "sigkill_timeout": 60}
LONG_STOP_WORDS = [f"{name}:={value}" for name, value in LONG_STOP.items()]


class World:
    """A private ROS domain and log folder; every process started here carries a mark."""

    def __init__(self, log_dir: Path, domain_id: int, stack: ExitStack) -> None:
        self.mark = uuid.uuid4().hex
        self.env = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(log_dir),
            "XDG_STATE_HOME": str(log_dir.with_name("state")),
            "TERM": "xterm-256color",
            MARK: self.mark,
        }
        for name in ("NO_COLOR", "FORCE_COLOR", "MAKEFLAGS", "MAKELEVEL", "MFLAGS"):
            self.env.pop(name, None)
        self._stack = stack

    def terminal(
        self, *command: str, cwd: Path = REPOSITORY, env: Mapping[str, str] | None = None
    ) -> Terminal:
        """Any command in a terminal of its own, here or in another environment."""
        there = {**(env or self.env), MARK: self.mark}
        return self._stack.enter_context(Terminal(command, env=there, cwd=cwd))

    def launcher(self, *words: str) -> Terminal:
        """`python -m launcher WORDS` in a terminal of its own; it waits long for ends."""
        return self.terminal(*self.command(*words, *LONG_STOP_WORDS))

    def command(self, *words: str) -> Sequence[str]:
        """The same as a list, for subprocess."""
        return [sys.executable, "-m", "launcher", *words]

    def survivors(self) -> list[str]:
        """What still runs of everything that was started here."""
        return list(marked_processes(MARK, self.mark))

    def close(self) -> None:
        for process in marked_processes(MARK, self.mark).values():
            with suppress(psutil.NoSuchProcess):
                process.kill()


@pytest.fixture
def world(tmp_path: Path) -> Iterator[World]:
    with leased_domain() as domain_id, ExitStack() as stack:
        one = World(tmp_path / "log", domain_id, stack)
        stack.callback(one.close)
        yield one
