"""How a process of several nodes ends, and what each of them has to do with it."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path

import pytest

from tests.run.process.compose.composed import end, logged, pid_of, plain, script, tasks
from tests.support.benches import ControlBench
from tests.support.waiting import wait_until

pytest.importorskip("rclpy")


@pytest.mark.parametrize(
    ("style", "text", "code"),
    [("fails", "IndexError", 1), pytest.param("exits", "", 3, marks=pytest.mark.thorough)],
    ids=["fails", "exits"],
)
def test_a_node_that_fails_takes_the_others_with_it(bench: ControlBench, style, text, code):
    handler = (
        "RegisterEventHandler(OnProcessExit(target_action=node, on_exit=lambda event, context: "
        "LogInfo(msg=f'{event.process_name} ended with {event.returncode}')))"
    )
    actions = (
        f"*(lambda node, other: [other, node, {handler}, {handler.replace('=node', '=other')}])"
        f"({plain(style)}, {plain('careful')})"
    )
    with bench.launch(actions, "--compose", "*") as run:
        assert run.exit_code() == 1
    assert f"[ERROR] [{style}-2]: node has died in composed-1 (exit code {code})" in run.screen
    assert "[careful-1] careful was stopped" in run.screen
    assert f"{style}-2 ended with {code}" in run.screen
    assert "careful-1 ended with 0" in run.screen
    assert f"exit code 1: composed-1 ended unexpectedly (exit code {code})" in run.screen
    assert not text or re.search(rf"\[{style}-2\] {text}: ", run.screen)


@pytest.mark.thorough
def test_a_restart_is_that_of_the_group(bench: ControlBench):
    actions = f"{plain('exits')}, {plain('careful')}"
    policy = "*=on-failure,max=1,delay=0.1"
    with bench.launch(actions, "--compose", "*", "--restart", policy) as run:
        assert run.exit_code() == 1
    assert run.screen.count("\n[careful-2] careful was stopped") == 2
    assert run.screen.count("\n[ERROR] [exits-1]: node has died in composed-1 (exit code 3)") == 2


def test_a_required_node_ends_the_run_and_another_does_not(bench: ControlBench):
    actions = f"{plain('words')}, {plain('words', name='more')}, {plain('careful')}"
    with bench.launch(actions, "--compose", "*") as run:
        run.wait_for("[INFO] [more-2]: node has finished cleanly in composed-1")
        run.wait_for("[careful-3] [INFO]")
        end(run)
    with bench.launch(actions, "--compose", "*", "--required", "more") as run:
        assert run.exit_code() == 0, run.screen
    assert "[INFO] [composed-1]: process has finished cleanly" in run.screen


def test_a_launch_file_stops_one_node_and_the_others_go_on(bench: ControlBench):
    stop = (
        "RegisterEventHandler(__import__('launch').event_handlers.OnProcessIO("
        "target_action=cat, on_stdout=lambda io: __import__('launch').actions.EmitEvent(event="
        "__import__('launch').events.process.ShutdownProcess("
        "process_matcher=lambda action: action is node))))"
    )
    cat = "sh('exec cat', name='cat')"
    actions = (
        f"*(lambda node, cat: [node, cat, {stop}])({plain('careful')}, {cat}), "
        f"{plain('careful', name='other')}, {plain('words')}"
    )
    with bench.launch(actions, "--compose", "*") as run:
        for process in ("careful-1", "other-3"):
            wait_until(lambda p=process: len(tasks(run, p)) == 2, "each hears both")
        run.ask("send", "cat", text="go")
        run.wait_for("[INFO] [careful-1]: node has finished cleanly in composed-1")
        assert run.row("composed-1")["state"] == "RUNNING"
        end(run)
    assert len(logged(run, "other-3", "other")) == 2  # in its only life
    assert run.screen.index("careful was stopped") < run.screen.index("other was stopped")


CRASHING = """
import os, signal, time
signal.signal(signal.SIGINT, lambda *_: os.kill(os.getpid(), signal.SIGSEGV))
print("ready", flush=True)
while True:
    time.sleep(0.01)
"""


def test_a_crash_of_a_group_that_is_stopped_is_a_death(bench: ControlBench, tmp_path: Path):
    action = script(tmp_path / "crashing.py", CRASHING)
    handler = (
        "RegisterEventHandler(OnProcessExit(on_exit=lambda event, context: "
        "LogInfo(msg=f'{event.process_name} ended with {event.returncode}')))"
    )
    with bench.launch(f"{action}, {plain('careful')}, {handler}", "--compose", "*") as run:
        run.wait_for("[crashing-1] ready")
        run.wait_for("[careful-2] [INFO]")
        run.ask("quit")
        assert run.exit_code() == 1
    assert "exit code 1: composed-1 ended unexpectedly (SIGSEGV" in run.screen
    assert "crashing-1 ended with -11" in run.screen


def test_a_killed_group_leaves_nothing(bench: ControlBench):
    with bench.launch(f"{plain('careful')}, {plain('usual')}", "--compose", "*") as run:
        run.wait_for("[usual-2] [INFO]")
        os.kill(pid_of(run), signal.SIGKILL)
        assert run.exit_code() == 1
    assert "composed-1 ended unexpectedly (SIGKILL)" in run.screen
