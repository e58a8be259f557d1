"""Signals whose exception Python drops: in destructors and callbacks of weak references."""

from __future__ import annotations

import subprocess
import sys

import pytest

from launcher.base.errors import ExitCode
from tests.support.verbs import TIMEOUT_S

# As the end of an import: `importlib._bootstrap._get_module_lock.<locals>.cb` is such a callback.
INTERRUPTED_IN_CALLBACK = """
import os, signal, sys, weakref

class Lock:
    pass

def interrupt(signum):
    lock = Lock()
    callback = lambda _: os.kill(os.getpid(), signum)
    reference = weakref.ref(lock, callback)
    del lock
"""
AS_A_VERB = """
import launcher.cli.dispatch
from launcher.__main__ import main

def verb(words):
    interrupt(signal.SIGINT)
    signal.pause()

launcher.cli.dispatch.main = verb
sys.exit(main())
"""
AS_A_BUILD = """
from launcher.posix import dispositions
from launcher.workspace.building.colcon import build_signals

dispositions.repeat_dropped_signals()
try:
    with build_signals.end_the_build():
        interrupt(signal.SIGTERM)
        signal.pause()
except build_signals.BuildTerminated as stop:
    sys.exit(build_signals.interrupted(stop, "ended"))
"""
ANOTHER_EXCEPTION = """
from launcher.posix import dispositions

dispositions.repeat_dropped_signals()
def fail(_):
    raise ValueError("in a callback")
lock = Lock()
reference = weakref.ref(lock, fail)
del lock
"""


def run(program: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", INTERRUPTED_IN_CALLBACK + program]
    return subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)


@pytest.mark.parametrize(
    ("program", "code", "text"),
    [
        pytest.param(AS_A_VERB, ExitCode.INTERRUPTED, "", id="verb"),
        pytest.param(AS_A_BUILD, ExitCode.TERMINATED, "\ninterrupted: ended\n", id="build"),
    ],
)
def test_a_signal_in_a_callback_ends_the_program(program: str, code: int, text: str):
    ended = run(program)
    assert (ended.returncode, ended.stderr) == (code, text)


def test_another_exception_in_a_callback_is_reported():
    ended = run(ANOTHER_EXCEPTION)
    assert ended.returncode == 0
    assert "ValueError: in a callback" in ended.stderr
