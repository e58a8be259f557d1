"""Tests of launch_pytest as users write them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HEAD = """
import sys
import launch, launch_pytest, pytest
from launch_pytest.tools import process as tools

ORDER = []
"""

TESTS = """
@pytest.fixture{0}
def process():
    return launch.actions.ExecuteProcess(cmd=["sh", "-c", "echo hello; echo world >&2; sleep 1000"],
                                         cached_output=True)

@launch_pytest.fixture{0}
def running(process):
    return launch.LaunchDescription([process])

@pytest.mark.launch(fixture=running, shutdown=True)
def test_ended(process, launch_service):
    ORDER.append("ended")
    assert process.return_code is not None and launch_service._is_idle()

@pytest.mark.launch(fixture=running)
async def test_coroutine(process, launch_context):
    ORDER.append("coroutine")
    assert await tools.wait_for_start(launch_context, process, timeout=60)
    said = lambda text: text == "world\\n"
    assert await tools.wait_for_stderr(launch_context, process, said, timeout=60)
    assert not await tools.wait_for_exit(launch_context, process, timeout=0.01)

@pytest.mark.launch(fixture=running)
def test_function(process, launch_context):
    ORDER.append("function")
    def said(text):
        assert text == "hello\\n"
    tools.assert_output_sync(launch_context, process, said, timeout=60)

@pytest.mark.launch(fixture=running)
def test_generator(process):
    ORDER.append("generator")
    assert process.return_code is None
    yield
    ORDER.append("generator after")
    assert process.return_code is not None

@pytest.mark.launch(fixture=running)
async def test_async_generator(process):
    assert process.return_code is None
    yield
    assert process.return_code is not None

@pytest.mark.launch
def test_incomplete():
    assert False

def test_order():
    assert {1} == ORDER
"""
EACH = ["ended", "coroutine", "function", "generator", "generator after"]
SHARED = ["coroutine", "function", "generator", "ended", "generator after"]


def outcome(folder: Path, text: str) -> str:
    (folder / "test_it.py").write_text(HEAD + text)
    result = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "."],
        cwd=folder,
        text=True,
        capture_output=True,
        timeout=300,
    )
    return result.stdout


def test_all_kinds_of_tests_with_a_launch_for_each(tmp_path: Path):
    said = outcome(tmp_path, TESTS.format("", EACH))

    assert "6 passed, 1 skipped" in said, said
    assert '"fixture" keyword argument is required' in said


@pytest.mark.thorough
def test_tests_of_a_module_share_a_launch_and_those_after_it_come_last(tmp_path: Path):
    said = outcome(tmp_path, TESTS.format("(scope='module')", SHARED))

    assert "8 passed, 1 skipped" in said, said


WRONG = """
@launch_pytest.fixture
def nothing():
    return object()

@launch_pytest.fixture
def twice():
    ready = launch_pytest.actions.ReadyToTest
    return [launch.LaunchDescription([ready(), ready()]), "more"]

@launch_pytest.fixture
def works():
    return launch.LaunchDescription([])

@pytest.mark.launch(fixture=nothing)
def test_nothing(): pass

@pytest.mark.launch(fixture=twice)
def test_twice(): pass

@pytest.mark.launch(fixture=works)
def test_long():
    yield
    yield

@pytest.mark.launch(fixture=works, shutdown=True)
def test_both():
    yield
"""


@pytest.mark.thorough
def test_what_is_written_wrongly_is_named(tmp_path: Path):
    said = outcome(tmp_path, WRONG)

    assert "2 failed, 2 errors" in said, said
    for text in (
        "'nothing': return value must be either a launch description or a sequence",
        "containing only one ReadyToTest action",
        "a generator function must stop iteration after yielding once",
        "cannot be marked with shutdown=True",
    ):
        assert text in said
