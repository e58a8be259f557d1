"""Levels and values of /diagnostics for the states of processes."""

from __future__ import annotations

import pytest

from launcher.ros.helpers.diagnostics import DiagnosticLevel, all_stale, service_names, statuses
from tests.support.watcher_stand_in import fault

RUN = {"id": "1-a", "pid": 1, "target": "x.launch.py", "log_dir": None, "domain_id": 7}


def row(**facts):
    return {
        "name": "robot_1-1",
        "label": "robot_1",
        "state": "RUNNING",
        "pid": 42,
        "restarts": 0,
        "uptime_s": 60.0,
        "cpu_percent": 12.34,
        "uss_bytes": 48_100_000,
        "threads": 3,
        "fds": 9,
        "node_names": ["/robot_1"],
        "paused": False,
        "last_exit": None,
        **facts,
    }


def end(returncode: int, *, asked: bool = False):
    return {
        "returncode": returncode,
        "text": f"exit code {returncode}",
        "asked": asked,
        "wall_s": 0.0,
    }


@pytest.mark.parametrize(
    ("facts", "level", "message"),
    [
        ({}, DiagnosticLevel.OK, "running"),
        ({"state": "STARTING"}, DiagnosticLevel.OK, "starting"),
        ({"paused": True}, DiagnosticLevel.WARN, "paused"),
        ({"host": "bot1", "unreachable_s": 4.2}, DiagnosticLevel.STALE, "running, unreachable 4 s"),
        ({"host": "bot1", "unreachable_s": None}, DiagnosticLevel.OK, "running"),
        (
            {"restarts": 2, "uptime_s": 1.0, "last_exit": end(3)},
            DiagnosticLevel.WARN,
            "restarted (2) after exit code 3",
        ),
        ({"restarts": 2, "last_exit": end(3)}, DiagnosticLevel.OK, "running"),
        (
            {"state": "BACKOFF", "last_exit": end(3)},
            DiagnosticLevel.WARN,
            "waiting to restart after exit code 3",
        ),
        (
            {"state": "STOPPED", "last_exit": end(0, asked=True)},
            DiagnosticLevel.STALE,
            "stopped by request",
        ),
        ({"state": "STOPPED"}, DiagnosticLevel.STALE, "not started"),
        (
            {"state": "STOPPED", "last_exit": end(-11, asked=False)},
            DiagnosticLevel.ERROR,
            "crashed when it was stopped: exit code -11",
        ),
        ({"state": "EXITED", "last_exit": end(0)}, DiagnosticLevel.OK, "finished"),
        ({"state": "EXITED", "last_exit": end(-15, asked=True)}, DiagnosticLevel.OK, "finished"),
        (
            {"state": "EXITED", "last_exit": end(3)},
            DiagnosticLevel.ERROR,
            "exited unexpectedly: exit code 3",
        ),
        ({"state": "FATAL", "last_exit": end(3)}, DiagnosticLevel.ERROR, "failed: exit code 3"),
        ({"state": "FATAL"}, DiagnosticLevel.ERROR, "failed: could not be started"),
    ],
)
def test_the_level_says_how_bad_it_is(facts, level, message):
    _, one = statuses([row(**facts)], RUN, "launcher")
    assert (one.name, one.level, one.message) == ("launcher: robot_1-1", level, message)


def test_values_are_those_that_are_known():
    _, one = statuses([row(cpu_percent=None)], RUN, "launcher")
    assert dict(one.values) == {
        "state": "RUNNING",
        "pid": "42",
        "nodes": "/robot_1",
        "uptime (s)": "60.0",
        "restarts": "0",
        "memory, USS (MB)": "48.1",
        "threads": "3",
        "open files": "9",
    }


def test_the_run_is_as_bad_as_its_worst_process():
    rows = [row(), row(name="b-2", state="BACKOFF"), row(name="c-3", state="FATAL")]
    run, *_ = statuses(rows, RUN, "launcher")
    assert run.level is DiagnosticLevel.ERROR
    assert run.message == "1 of 3 processes running; see b-2, c-3"
    assert dict(run.values) == {"id": "1-a", "pid": "1", "target": "x.launch.py", "domain_id": "7"}


def test_active_faults_count_for_the_run_and_healed_ones_stay_as_ok():
    healed = fault("d", state="healed", healed_s=1.0)
    mute = {"reason": None, "until_s": None}
    faults = [
        fault("a", acknowledged={"wall_s": 1.0, "reason": "seen"}, cause=None),
        fault("b", muted=mute),
        fault("c", state="suspected", count=0),
        healed,
    ]
    run, _, a, d = statuses([row()], RUN, "launcher", faults)
    assert (a.level, a.message) == (DiagnosticLevel.WARN, "no message for 3.0 s")
    assert a.name == "launcher: fault a"
    assert dict(a.values)["acknowledged"] == "seen"
    assert (d.level, d.message) == (DiagnosticLevel.OK, "healed")
    assert (run.level, run.message) == (DiagnosticLevel.WARN, "1 of 1 process running, 1 fault")

    run, *_, e = statuses([row()], RUN, "launcher", [healed, fault("e")])
    assert run.level is e.level is DiagnosticLevel.ERROR
    assert e.message == "no message for 3.0 s; cat-1 was killed (SIGKILL)"


def test_a_stopped_process_is_not_an_error():
    run, _ = statuses([row(state="STOPPED", last_exit=end(0, asked=True))], RUN, "launcher")
    assert (run.level, run.message) == (DiagnosticLevel.OK, "0 of 1 process running")


def test_what_is_stale_keeps_its_values():
    before = statuses([row()], RUN, "launcher")
    after = all_stale(before, "gone")
    assert [one.level for one in after] == [DiagnosticLevel.STALE, DiagnosticLevel.STALE]
    assert after[1].values == before[1].values


def test_services_have_names_that_ros_takes():
    rows = [
        row(name="robot_1-1", label="robot_1"),
        row(name="sleep-2", label="sleep"),
        row(name="sleep-3", label="sleep"),
        row(name="7z-4", label="7z"),
        row(name="./a.b-5", label="./a.b"),
    ]
    assert service_names(rows) == {
        "robot_1-1": "robot_1",
        "sleep-2": "sleep_2",
        "sleep-3": "sleep_3",
        "7z-4": "p7z",
        "./a.b-5": "a_b",
    }
