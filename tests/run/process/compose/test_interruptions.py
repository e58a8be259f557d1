"""Signals, and the calls that they interrupt, in the process of several nodes."""

from __future__ import annotations

import ctypes
import re
import signal
from pathlib import Path

import psutil
import pytest

from launcher.posix import proc
from tests.run.process.compose.composed import end, pid_of, plain, script
from tests.support.benches import ControlBench

pytest.importorskip("rclpy")


def test_sigterm_is_what_each_node_makes_of_it(bench: ControlBench):
    actions = ", ".join(plain(style) for style in ("careful", "loop", "threads"))
    with bench.launch(actions, "--compose", "*", "--stop", "*=term:30") as run:
        for name in ("careful-1", "loop-2", "threads-3"):
            run.wait_for(f"[{name}] [INFO]")
        end(run)
    assert "[loop-2] loop got SIGTERM" in run.screen
    assert "[loop-2] loop is not ok any more" in run.screen
    assert "[INFO] [loop-2]: node was stopped in composed-1 (exit code 1)" in run.screen
    assert "[careful-1] careful was stopped" in run.screen
    assert "threads was stopped" not in run.screen  # this executor returns without an exception


def test_a_signal_counts_whichever_thread_it_interrupts(bench: ControlBench):
    """The kernel may deliver it to any thread; the main thread, which acts on it, sleeps then."""
    with bench.launch(f"{plain('careful')}, {plain('threads')}", "--compose", "*") as run:
        for name in ("careful-1", "threads-2"):
            run.wait_for(f"[{name}] [INFO]")
        pid = pid_of(run)
        threads = [one.id for one in psutil.Process(pid).threads() if one.id != pid]
        tid = next(tid for tid in threads if not _blocks(pid, tid, signal.SIGINT))
        assert ctypes.CDLL(None).tgkill(pid, tid, signal.SIGINT) == 0
        assert run.exit_code() == 0
    assert "[INFO] [careful-1]: node has finished cleanly in composed-1" in run.screen


def _blocks(pid: int, tid: int, signum: int) -> bool:
    status = proc.read(f"{pid}/task/{tid}", "status").decode()  # empty if it has ended
    mask = re.search(r"^SigBlk:\s+(\w+)", status, re.MULTILINE)
    return mask is None or bool(int(mask[1], 16) & 1 << (signum - 1))


DESTRUCTOR = """
import time
class Slow:
    def __del__(self):
        print("ready", flush=True)
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            pass
try:
    Slow()
    while True:
        time.sleep(0.01)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
# Its import takes until the signal has come, and holds the lock that other imports need.
IMPORT = """
import time
print("ready", flush=True)
end = time.monotonic() + 1.0
while time.monotonic() < end:
    pass
"""
IMPORTING = """
import sys
sys.path.insert(0, {folder!r})
try:
    import slow_to_import
    import time
    while True:
        time.sleep(0.01)
except KeyboardInterrupt:
    print("interrupted", "slow_to_import" in sys.modules, flush=True)
"""
# It hardly does anything but start threads.
STARTING = """
import threading
print("ready", flush=True)
try:
    while True:
        threading.Thread(target=int).start()
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
# Timers that would end a process of its own, and those that it handles.
TIMERS = """
import signal
for which in (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF):
    assert signal.setitimer(which, 0.001) == (0.0, 0.0)
assert signal.alarm(1) == 0
signal.signal(signal.SIGALRM, lambda *_: None)
for call in (lambda: signal.alarm(1), lambda: signal.setitimer(signal.ITIMER_REAL, 1.0)):
    try:
        call()
    except RuntimeError as error:
        print(error, flush=True)
signal.setitimer(signal.ITIMER_PROF, 2.0)
print("all tried", flush=True)
"""


def test_an_interrupt_that_a_destructor_drops_comes_again(bench: ControlBench, tmp_path: Path):
    action = script(tmp_path / "slow.py", DESTRUCTOR)
    with bench.launch(f"{action}, {plain('careful')}", "--compose", "*") as run:
        run.wait_for("[slow-1] ready")
        end(run)
    assert "[slow-1] interrupted" in run.screen
    assert "escalating" not in run.screen


@pytest.mark.thorough
def test_a_timer_is_refused_if_its_node_would_be_called(bench: ControlBench, tmp_path: Path):
    action = script(tmp_path / "timers.py", TIMERS)
    with bench.launch(f"{action}, {plain('careful')}", "--compose", "*") as run:
        run.wait_for("[timers-1] all tried")
        end(run)
    for name in ("alarm", "setitimer"):
        text = f"[timers-1] signal.{name} does not work in a composed node: it is of the process"
        assert run.screen.count(text) == 1, run.screen


@pytest.mark.thorough
def test_an_interrupt_waits_for_the_end_of_an_import(bench: ControlBench, tmp_path: Path):
    (tmp_path / "slow_to_import.py").write_text(IMPORT, encoding="utf-8")
    action = script(tmp_path / "importing.py", IMPORTING.format(folder=str(tmp_path)))
    with bench.launch(f"{action}, {plain('careful')}", "--compose", "*") as run:
        run.wait_for("[importing-1] ready")
        end(run)
    assert "[importing-1] interrupted True" in run.screen
    assert "escalating" not in run.screen


@pytest.mark.thorough
def test_an_interrupt_reaches_a_thread_that_starts_others(bench: ControlBench, tmp_path: Path):
    """Python gives a new thread the identity of the one that starts it, until it runs."""
    actions = ", ".join(script(tmp_path / f"starting_{n}.py", STARTING) for n in range(8))
    with bench.launch(f"{actions}, {plain('careful')}", "--compose", "*") as run:
        for number in range(8):
            run.wait_for(f"[starting_{number}-{number + 1}] ready")
        end(run)
    assert run.screen.count("] interrupted\n") == 8
    assert "Exception ignored" not in run.screen
    assert "escalating" not in run.screen
