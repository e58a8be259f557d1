"""Runs with a page, each in a ROS domain and a runtime folder of its own; a browser."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from launcher.posix.domain_lease import leased_domain
from tests.support.browser import chromium
from tests.support.controlled_run import ControlledRun
from tests.support.web_page import run_with_page

Start = Callable[..., tuple[ControlledRun, str]]
Command = Callable[..., "subprocess.CompletedProcess[str]"]


@contextlib.contextmanager
def starting(folder: Path) -> Iterator[Start]:
    """`start(target, *words)`: a run and the link of its page, until the end of the block."""
    with contextlib.ExitStack() as stack:

        def begin(target: Path | str, *words: str, **env: str) -> tuple[ControlledRun, str]:
            runtime = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="run-")))
            domain = stack.enter_context(leased_domain())
            environment = {
                **os.environ,
                "ROS_DOMAIN_ID": str(domain),
                "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
                "ROS_LOG_DIR": str(folder / "log"),
                **env,
            }
            screen = folder / f"screen-{domain}"
            return stack.enter_context(run_with_page(target, words, environment, runtime, screen))

        yield begin


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """`start(target, *words)`: a run and the link of its page; it ends with the test."""
    with starting(tmp_path) as begin:
        yield begin


@pytest.fixture
def sleeper(tmp_path: Path) -> Path:
    """A launch file with a process that says what is written to it."""
    path = tmp_path / "cat.launch.py"
    path.write_text(
        "from launch import LaunchDescription\n"
        "from launch.actions import ExecuteProcess\n\n\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([ExecuteProcess(cmd=['cat'], name='cat', output='screen')])\n"
    )
    return path


@pytest.fixture
def command(tmp_path: Path) -> Command:
    """`command(*words)`: `python -m launcher` to its end."""

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "launcher", *words],
            env={**os.environ, "ROS_LOG_DIR": str(tmp_path / "log")},
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )

    return run


@pytest.fixture(scope="session")
def started() -> Iterator[Browser]:
    """A browser that all tests share."""
    with chromium() as browser:
        yield browser
