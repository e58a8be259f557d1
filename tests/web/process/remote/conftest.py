"""Runs of one process, and MCP servers as clients start them."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.support.controlled_run import ControlledRun

StartRun = Callable[[], ControlledRun]


@pytest.fixture
def environment() -> Iterator[dict[str, str]]:
    """With a folder for sockets that is this test's alone, whose path is short."""
    with tempfile.TemporaryDirectory(prefix="run-") as runtime:
        yield {**os.environ, "XDG_RUNTIME_DIR": runtime, "TMPDIR": runtime}


@pytest.fixture
def start(tmp_path: Path, environment: dict[str, str], sleeper: Path) -> Iterator[StartRun]:
    """`start()`: a run that listens; it ends with the test."""
    with contextlib.ExitStack() as stack:

        def begin() -> ControlledRun:
            run = ControlledRun(
                [sys.executable, "-m", "launcher", str(sleeper), "--no-console"],
                env=environment,
                runtime=Path(environment["XDG_RUNTIME_DIR"]),
                screen=tmp_path / f"screen-{len(list(tmp_path.glob('screen-*')))}",
            )
            stack.enter_context(run)
            assert run.socket
            return run

        yield begin
