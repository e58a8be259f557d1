"""Ctrl-C and SIGTERM in pytest while a launch runs, which takes them: pytest ends, too."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.children import is_alive
from tests.support.waiting import rest_of, wait_until

DESCRIPTION = """
import threading, unittest
import launch, launch_pytest, launch_testing.actions, pytest

def running():
    command = ["sh", "-c", "echo $$ > pid.new; mv pid.new pid; exec sleep 1000"]
    process = launch.actions.ExecuteProcess(cmd=command)
    return launch.LaunchDescription([process, launch_testing.actions.ReadyToTest()])
"""
OF_LAUNCH_TESTING = """
@pytest.mark.launch_test
def generate_test_description():
    return running()

class TestRunning(unittest.TestCase):
    def test_waits(self):
        threading.Event().wait()
"""
OF_LAUNCH_PYTEST = """
@launch_pytest.fixture
def launched():
    return running()

@pytest.mark.launch(fixture=launched)
{}
"""
KINDS = {
    "launch_testing": OF_LAUNCH_TESTING,
    "function": OF_LAUNCH_PYTEST.format("def test_waits(): threading.Event().wait()"),
    "coroutine": OF_LAUNCH_PYTEST.format(
        "async def test_waits():\n    import asyncio\n    await asyncio.Event().wait()"
    ),
    "generator": OF_LAUNCH_PYTEST.format(
        "def test_waits():\n    threading.Event().wait()\n    yield"
    ),
}


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("kind", "signum"),
    [*((kind, signal.SIGINT) for kind in KINDS), ("launch_testing", signal.SIGTERM)],
)
def test_one_signal_ends_pytest_and_the_launch(tmp_path: Path, kind: str, signum: int):
    (tmp_path / "test_a.py").write_text(DESCRIPTION + KINDS[kind])
    (tmp_path / "test_b.py").write_text("def test_later(): open('later', 'w')\n")
    run = subprocess.Popen(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "."],
        cwd=tmp_path,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    wait_until((tmp_path / "pid").exists, "the process of the launch")
    run.send_signal(signum)
    out, err = rest_of(run)

    assert run.returncode == pytest.ExitCode.INTERRUPTED, out + err
    assert ("KeyboardInterrupt" if signum == signal.SIGINT else "SIGTERM") in out, out
    assert "OK" not in err
    assert not is_alive(int((tmp_path / "pid").read_text()))
    assert not (tmp_path / "later").exists()
