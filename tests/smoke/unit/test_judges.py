"""Judges of processes, lines and the run, on made-up facts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from launcher.smoke.expect.expectation import Decision
from launcher.smoke.expect.expectation_kinds import KINDS
from launcher.smoke.judges import judge
from launcher.smoke.observe.facts import Ending
from tests.smoke.unit.cases import STEPS, Case, log
from tests.smoke.unit.facts import (
    END_S,
    ended,
    event,
    expectation,
    lines,
    ready,
    running,
    samples,
    seen,
    signalled,
    started,
    ticks,
    unready,
)

MET, VIOLATED, OPEN = Decision.MET, Decision.VIOLATED, Decision.OPEN
TWO = started("robot_1-1", "robot_2-2")
CASES = {
    "log": Case(
        "log: 'task \\d', process: robot_1, level: WARN, within: 3 s",
        log("[WARN] [robot_1]: task 7"),
        log("[INFO] [robot_1]: task 7"),
        "no such line; one of level INFO",
    ),
    "log of another process": Case(
        "log: task, process: robot_1",
        log("task"),
        {"lines": lines("task", process="robot_2-2"), "events": TWO},
        "no such line among 0",
        "robot_1-1 printed nothing",
    ),
    "log of a process that is not there": Case(
        "log: task, process: robot_1",
        log("task"),
        {"lines": lines("task", process="robot_2-2"), "events": started("robot_2-2")},
        "no such line among 0",
        "no process is named robot_1; there are: robot_2-2",
    ),
    "log of the launcher": Case(
        "log: process started, process: launch",
        {"lines": lines("process started", process=None)},
        log("process started"),
        "no such line among 0",
    ),
    "log too late": Case(
        "log: task, within: 3 s",
        log("task"),
        log("task", at_s=4.0),
        "too late, after 4.0 s",
    ),
    "log too early": Case(
        "log: silent, within: 5 to 8 s, after: kill",
        {**log("silent", at_s=11.0), **STEPS},
        {**log("silent", at_s=6.0), **STEPS},
        "too early, after 1.0 s",
    ),
    "log before the step": Case(
        "log: again, after: kill",
        {**log("again", at_s=6.0), **STEPS},
        {**log("again", at_s=2.0), **STEPS},
        "only before, at 2.0 s of the run",
    ),
    "log at least": Case("log: task, count: '>= 2'", log("task", "task"), log("task"), "1"),
    "log at most": Case(
        "log: task, count: <= 1", log("task"), log("task", "task"), "2; one too many after 2.0 s"
    ),
    "log forbidden": Case("log: task, count: 0", log("job"), log("task"), "1; one too many"),
    "log in colour": Case(
        "log: '^a task$'", log("\x1b[33ma task\x1b[0m"), log("a  task"), "no such line among 1"
    ),
    "order": Case(
        "order: [first, second, third]",
        log("first", "second", "noise", "third"),
        log("first", "third", "second"),
        "'third' came before 'second'",
    ),
    "order with a gap": Case(
        "order: [first, second]", log("first", "second"), log("first"), "no line with 'second'"
    ),
    "no errors": Case(
        "no_errors: '*', except: [harmless]",
        log("[WARN] [a]: x", "[ERROR] [a]: harmless"),
        log("[ERROR] [a]: broken", "[FATAL] [a]: more"),
        "2, the first after 1.0 s: [robot_1-1] [ERROR] [a]: broken",
    ),
    "no errors of the launcher": Case(
        "no_errors: '*'",
        {"lines": lines("[INFO] [robot_1-1]: process started", process=None)},
        {"lines": lines("[ERROR] [robot_1-1]: process has died", process=None)},
        "process has died",
    ),
    "no tracebacks": Case(
        "no_tracebacks: robot_1",
        log("Traceback (most recent call last):", "  x", "KeyboardInterrupt", at_s=END_S),
        log("Traceback (most recent call last):", "  x", "KeyError: 3"),
        "after 3.0 s: [robot_1-1] KeyError: 3",
    ),
    "alive": Case(
        "process: robot_1",
        {},
        {"events": (*started("robot_1-1"), ended("robot_1-1", -11, 4.0))},
        "robot_1-1 ended at 4.0 s of the run with SIGSEGV",
    ),
    "alive until the stop": Case(
        "process: robot_1",
        {"events": (*started("robot_1-1"), ended("robot_1-1", 0, END_S + 0.1, asked=True))},
        {"events": (*started("robot_1-1"), ended("robot_1-1", 0, END_S - 0.1))},
        "exit code 0",
    ),
    "alive all": Case(
        "process: robot_*",
        {"events": TWO},
        {"events": (*TWO, ended("robot_2-2", 0, 4.0))},
        "robot_2-2 ended",
    ),
    "not alive": Case(
        "process: robot_1, alive: false",
        {"events": (*started("robot_1-1"), ended("robot_1-1", 0, 4.0))},
        {},
        "robot_1-1 still ran",
    ),
    "no such process": Case("process: robot_1", {}, {"events": started("x-1")}, "there are: x-1"),
    "exit code": Case(
        "process: robot_1, exits: 3, within: 5 s",
        {"events": (*started("robot_1-1"), ended("robot_1-1", 3, 4.0))},
        {"events": (*started("robot_1-1"), ended("robot_1-1", 0, 4.0))},
        "robot_1-1 ended with exit code 0 after 4.0 s",
    ),
    "exit in time": Case(
        "process: robot_1, exits: SIGKILL, within: 5 s",
        {"events": (*started("robot_1-1"), ended("robot_1-1", -9, 4.0))},
        {"events": (*started("robot_1-1"), ended("robot_1-1", -9, 6.0))},
        "did not end in time, but after 6.0 s",
    ),
    "restarts": Case(
        "process: robot_1, restarts: 1",
        {"events": (*started("robot_1-1"), *started("robot_1-1", at_s=3))},
        {"events": started("robot_1-1")},
        "robot_1-1: 0 restarts",
    ),
    "no deaths": Case(
        "no_deaths: '*'",
        {"events": (*TWO, ended("robot_1-1", 0, 4.0), ended("robot_2-2", -9, 4.0, asked=True))},
        {"events": (*TWO, ended("robot_1-1", 1, 4.0))},
        "robot_1-1 exited at 4.0 s of the run with exit code 1",
    ),
    "ready": Case(
        "ready: robot_*, within: 5 s",
        {"events": (*TWO, *(ready(name, 2.0) for name in ("robot_1-1", "robot_2-2")))},
        {"events": (*TWO, ready("robot_1-1", 2.0), unready("robot_2-2", 1.0))},
        "robot_2-2 has no publisher on /t",
    ),
    "ready without facts": Case(
        "ready: robot_1, within: 5 s",
        {"events": (*TWO, ready("robot_1-1", 0.5))},
        {"events": TWO},
        "robot_1-1 has no 'ready_when' in a supervision file",
    ),
    "ready too late": Case(
        "ready: robot_1, within: 1 s",
        {"events": (*TWO, ready("robot_1-1", 0.5))},
        {"events": (*TWO, ready("robot_1-1", 2.0))},
        "robot_1-1 was ready after 2.0 s",
    ),
    "ready of one that waits": Case(
        "ready: robot_3",
        {"events": (*started("robot_3-1"), ready("robot_3-1", 2.0))},
        {"events": (event("waiting", "robot_3-1", 0.5),)},
        "robot_3-1 waits for others",
    ),
    "cpu": Case(
        "cpu: robot_*, below: 50 %, peak: 90 %",
        {"samples": samples("robot_1-1", (40, 10), (50, 10))},
        {"samples": samples("robot_1-1", (40, 10), (95, 10))},
        "robot_1-1 67.5 % on average, robot_1-1 95.0 % at most",
    ),
    "cpu peak": Case(
        "cpu: robot_1, peak: 90 %",
        {"samples": samples("robot_1-1", (40, 10), (50, 10))},
        {"samples": samples("robot_1-1", (10, 10), (95, 10))},
        "95.0 % at most",
    ),
    "cpu not measured": Case(
        "cpu: robot_1, below: 9 %",
        {"samples": samples("robot_1-1", (4, 10))},
        {},
        "nothing was measured",
    ),
    "memory": Case(
        "memory: robot_1, below: 100 MB",
        {"samples": samples("robot_1-1", (1, 99))},
        {"samples": samples("robot_1-1", (1, 99), (1, 101))},
        "robot_1-1 101.0 MB at 2.0 s of the run",
    ),
    "growth of memory": Case(
        "memory: robot_1, below: 1 GB, growth: 120 MB/min",
        {"samples": samples("robot_1-1", *((1, 100 + (9 - n if n < 9 else n)) for n in range(19)))},
        {"samples": samples("robot_1-1", *((1, 100 + 3 * n) for n in range(19)))},
        "robot_1-1 +180 MB/min",
    ),
    "start-up": Case(
        "start_up: 3 s",
        {"steps": {"ready": 2.9}},
        {"steps": {"ready": 3.1}},
        "after 3.1 s",
    ),
    "shutdown": Case(
        "clean_shutdown: 2 s",
        {"ending": Ending(asked_s=END_S, down_s=END_S + 1.9, returncode=0)},
        {"ending": Ending(asked_s=END_S, down_s=END_S + 2.1, returncode=0)},
        "it took 2.1 s",
    ),
    "shutdown by force": Case(
        "clean_shutdown: 8 s",
        {"events": (*started("a-1"), signalled("a-1", 2, END_S + 0.1))},
        {"events": (*started("a-1"), signalled("a-1", 15, END_S + 0.1))},
        "a-1 needed SIGTERM",
    ),
    "shutdown with a crash": Case(
        "clean_shutdown: 8 s",
        {"events": (*started("a-1"), ended("a-1", -2, END_S + 0.1, asked=True))},
        {"events": (*started("a-1"), ended("a-1", -11, END_S + 0.1, asked=True))},
        "a-1 ended with SIGSEGV",
    ),
    "shutdown with a crash by a signal of nobody here": Case(
        "clean_shutdown: 8 s",
        {"events": (*started("a-1"), ended("a-1", -9, END_S + 0.1, asked=True))},
        {"events": (*started("a-1"), ended("a-1", -9, END_S + 0.1))},
        "a-1 ended with SIGKILL",
    ),
    "shutdown with leftovers": Case(
        "clean_shutdown: 8 s",
        {},
        {
            "ending": Ending(
                asked_s=END_S, down_s=END_S, returncode=0, left_processes=("sleep 9 [7]",)
            )
        },
        "left behind: sleep 9 [7]",
    ),
    "shutdown of a stuck launcher": Case(
        "clean_shutdown: 8 s",
        {},
        {"ending": Ending(asked_s=END_S, down_s=END_S, returncode=None)},
        "the launcher had to be killed",
    ),
    "shared memory": Case(
        "shared_memory: clean",
        {},
        {"ending": Ending(asked_s=END_S, down_s=END_S, returncode=0, left_memory=("fastrtps_0",))},
        "1: fastrtps_0",
        "a killed process cannot free its shared memory",
    ),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_an_expectation_is_met_or_not_and_says_what_was_seen(case: Case):
    case.check()


def test_every_kind_is_there():
    judged = {expectation(case.entry).kind for case in CASES.values()}
    assert judged == {kind.name for kind in KINDS if not kind.needs_ros}


# ---- while the run goes on


@pytest.mark.parametrize(
    ("entry", "facts", "outcome"),
    [
        ("node: /a, within: 5 s", {"now_s": 4.0}, OPEN),
        ("node: /a, within: 5 s", {"now_s": 5.2}, OPEN),
        ("node: /a, within: 5 s", {"now_s": 6.0}, VIOLATED),
        ("log: x, count: 0, within: 5 s", {"now_s": 4.0}, OPEN),
        ("log: x, count: 0, within: 5 s", {"now_s": 6.0}, MET),
        ("log: x, count: 0", {"now_s": 6.0, "lines": lines("x")}, VIOLATED),
        ("log: x", {"now_s": 3.0, "lines": lines("x")}, MET),
        ("log: x, after: kill", {"now_s": 30.0, "lines": lines("x")}, OPEN),
        ("process: robot_1", {"now_s": 30.0}, OPEN),
        ("no_deaths: '*'", {"now_s": 30.0}, OPEN),
        ("rate: /t, is: 1 Hz", {"now_s": 9.0, "messages": ticks("/t", 1.0, to_s=9)}, OPEN),
        ("rate: /t, is: 1 Hz, within: 8 s", {"now_s": 9, "messages": ticks("/t", 1.0)}, MET),
        ("start_up: 5 s", {"now_s": 4.0}, OPEN),
        ("start_up: 5 s", {"now_s": 6.0}, VIOLATED),
        ("clean_shutdown: 5 s", {"now_s": 6.0}, OPEN),
    ],
)
def test_a_verdict_is_given_as_soon_as_it_is_certain(
    entry: str, facts: dict[str, Any], outcome: Decision
):
    assert judge(expectation(entry), running(**facts)).outcome is outcome


def test_a_step_that_never_happened_is_reported():
    wanted = expectation("log: x, after: kill")
    assert judge(wanted, running(30.0)).outcome is OPEN
    found = judge(wanted, seen(lines=lines("x")))
    assert (found.outcome, found.seen) == (VIOLATED, "the step 'kill' never happened")


def test_an_excepted_or_requested_exit_is_no_failure():
    events = (*started("robot_1-1"), ended("robot_1-1", 3, 4.0))
    wanted = expectation("no_deaths: '*'")
    announced = replace(wanted, values={"but": ("robot_1",)})
    assert judge(announced, seen(events=events)).outcome is MET
    assert (
        judge(wanted, seen(events=events, ended_by_steps=frozenset({"robot_1-1"}))).outcome is MET
    )
