"""Verbs of the command line in the console: what is shown, how they end, what is completed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import psutil
import pytest

from launcher.control.console.guard import GUARD
from tests.control.process.test_console_terminal import console_of
from tests.support.benches import Bench
from tests.support.console_runs import TICKS
from tests.support.screen_terminal import ScreenTerminal
from tests.support.waiting import wait_until

PUB = "topic pub /stream std_msgs/msg/String 'data: on' -r 20 -w 0 -p 1"


@pytest.fixture
def terminal(bench: Bench) -> ScreenTerminal:
    """A run with its prompt."""
    terminal = bench.screen_terminal(TICKS, rows=40)
    terminal.wait_for_prompt()
    terminal.enter("mute robot_*")
    terminal.wait_for("| robot_2-2 is muted")
    return terminal


def end(terminal: ScreenTerminal) -> None:
    terminal.enter("quit")
    assert terminal.exit_code() == 0


def stream(terminal: ScreenTerminal) -> None:
    """Start a verb that has no end."""
    terminal.enter(PUB)
    terminal.wait_for("| publishing #1: ")
    terminal.wait_until(lambda: "Ctrl-C ends `topic pub" in terminal.text, "the status bar tells")


def verbs_of(bench: Bench) -> list[str]:
    return [line for line in bench.survivors() if "launcher topic pub" in line]


@pytest.mark.thorough
def test_what_a_verb_prints_is_shown_as_an_answer(terminal: ScreenTerminal):
    terminal.enter("interface show std_msgs/msg/String")
    terminal.wait_for("> interface show std_msgs/msg/String", "| string data")
    terminal.enter("topic list")
    terminal.wait_for("| /parameter_events", "| /rosout")
    terminal.enter("interface show std_msgs/msg/Strin")
    terminal.wait_for("| Unknown interface 'std_msgs/msg/Strin'", "| exit code 1")
    terminal.enter("help node")
    terminal.wait_for("| usage: ", "| List and inspect nodes.")
    terminal.wait_until(lambda: "Ctrl-C ends `" not in terminal.text, "no verb runs")
    end(terminal)


def test_a_verb_streams_while_the_run_is_controlled(terminal: ScreenTerminal):
    stream(terminal)
    terminal.enter("stop monitor")
    terminal.wait_for("| monitor-3 stopped in ")
    terminal.wait_for("| publishing #100: ")
    terminal.ctrl_c()
    terminal.wait_until(lambda: "Ctrl-C ends `" not in terminal.text, "the verb has ended")
    terminal.enter("unmute")
    terminal.wait_for("[robot_1-1] tick")  # the run goes on
    assert not any("exit code" in row for row in terminal.scrolled if row.startswith("| "))
    end(terminal)


@pytest.mark.thorough
def test_a_second_verb_waits_for_the_first(terminal: ScreenTerminal):
    terminal.enter("topic hz /nothing --for 2")
    terminal.enter("interface show std_msgs/msg/Bool")
    terminal.wait_for(
        "| waits until `topic hz /nothing --for 2` has ended; Ctrl-C ends that one", "| bool data"
    )
    shown = [row for row in terminal.scrolled if row.startswith("> interface")]
    assert len(shown) == 2  # again above its output
    end(terminal)


@pytest.mark.thorough
def test_ctrl_c_leaves_out_what_waits(terminal: ScreenTerminal, bench: Bench):
    stream(terminal)
    terminal.enter("interface show std_msgs/msg/Bool")
    terminal.wait_for("| waits until `topic pub")
    terminal.ctrl_c()
    terminal.wait_for("| left out: `interface show std_msgs/msg/Bool`")
    wait_until(lambda: not verbs_of(bench), "the verb has ended")
    terminal.wait_until(lambda: "Ctrl-C ends `" not in terminal.text, "the status bar tells")
    terminal.enter("interface show std_msgs/msg/Char")
    terminal.wait_for("| char data")
    assert not any("bool data" in row for row in terminal.scrolled)
    end(terminal)


@pytest.mark.thorough
def test_a_mistake_in_a_line_ends_nothing(terminal: ScreenTerminal):
    terminal.enter("topic list 'unfinished")
    terminal.wait_for("error: the line is not finished: No closing quotation")
    terminal.enter("attach")
    terminal.wait_for("error: 'attach' is a verb for shells", "attach")
    terminal.enter("topc list")
    terminal.wait_for("hint: did you mean 'topic'?")
    end(terminal)


def test_tab_completes_as_in_a_shell(terminal: ScreenTerminal):
    terminal.type("interf\t")
    terminal.wait_until(lambda: "> interface" in terminal.rows, "the verb")
    terminal.type("sho\t")
    terminal.wait_until(lambda: "> interface show" in terminal.rows, "the verb below it")
    terminal.type("geometry_msgs/msg/TwistWithCovarianceS\t")
    terminal.wait_until(lambda: "TwistWithCovarianceStamped" in terminal.text, "the type")
    terminal.type("\x15topic echo --qos-prof\t")
    terminal.wait_until(lambda: "> topic echo --qos-profile" in terminal.text, "the option")
    terminal.type("\x15topic \t")
    terminal.wait_until(lambda: "echo" in terminal.text and "find" in terminal.text, "all verbs")
    terminal.type("\x15")
    end(terminal)


def test_the_verb_ends_with_the_run(terminal: ScreenTerminal, bench: Bench):
    stream(terminal)
    end(terminal)
    wait_until(lambda: not bench.survivors(), "nothing is left")


@pytest.mark.thorough
def test_a_killed_console_leaves_no_verb(terminal: ScreenTerminal, bench: Bench):
    stream(terminal)
    assert verbs_of(bench)
    console_of(terminal.pid).kill()
    terminal.wait_for("the console died (SIGKILL)")
    wait_until(lambda: not verbs_of(bench), "the verb has ended")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    wait_until(lambda: not bench.survivors(), "nothing is left")


@pytest.mark.thorough
def test_a_killed_launcher_leaves_no_verb(terminal: ScreenTerminal, bench: Bench):
    stream(terminal)
    terminal.kill()
    wait_until(lambda: not bench.survivors(), "nothing is left")


# ---- the guard


@contextmanager
def guarded(script: str) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """A guard with a shell, and the console's end of the lifeline."""
    orders, lifeline = os.pipe()
    shell = ["/bin/sh", "-c", script]
    guard = subprocess.Popen(
        [sys.executable, "-I", "-S", GUARD, str(orders), *shell],
        pass_fds=[orders],
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    os.close(orders)
    try:
        yield guard, lifeline
    finally:
        guard.communicate()


def first_line(guard: subprocess.Popen[str]) -> int:
    assert guard.stdout is not None
    return int(guard.stdout.readline())


@pytest.mark.parametrize(
    ("script", "code"), [("exit 7", 7), ("true", 0), ("kill -KILL $$", 128 + signal.SIGKILL)]
)
def test_the_guard_has_the_exit_code_of_the_verb(script: str, code: int):
    with guarded(script) as (guard, lifeline):
        assert guard.wait() == code
        os.close(lifeline)


def test_signals_reach_the_verb_and_what_it_has_started():
    below = "trap 'echo told; exit 3' INT; echo ready; while :; do sleep 0.1; done"
    with guarded(f'trap : INT; sh -c "{below}"; exit 5') as (guard, lifeline):
        assert guard.stdout is not None
        assert guard.stdout.readline() == "ready\n"
        os.write(lifeline, bytes([signal.SIGINT]))
        assert guard.stdout.readline() == "told\n"
        assert guard.wait() == 5
        os.close(lifeline)


STUBBORN = "trap '' INT; echo $$; while :; do sleep 0.1; done"


def test_a_verb_that_does_not_end_is_killed_the_second_time():
    with guarded(STUBBORN) as (guard, lifeline):
        first_line(guard)
        for signum in (signal.SIGINT, signal.SIGKILL):
            os.write(lifeline, bytes([signum]))
        assert guard.wait() == 128 + signal.SIGKILL
        os.close(lifeline)


@pytest.mark.thorough
def test_a_verb_that_does_not_end_is_killed_when_the_console_is_gone():
    with guarded(STUBBORN) as (guard, lifeline):
        pid = first_line(guard)
        os.close(lifeline)
        assert guard.wait() == 128 + signal.SIGKILL
        assert not psutil.pid_exists(pid)
