"""Whole smoke runs on real processes, and their exit codes."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.smoke.observe.left_behind import processes_of
from tests.smoke.process.bench import BRIEF, DEAF, DONE, IMPATIENT, PATIENT, SHORT, Bench
from tests.support.children import is_alive
from tests.support.hostile_parent import with_signals
from tests.support.waiting import wait_until

NODE = "--expect-node=/nowhere=1s"
UNTIL_DEAF = "{expect: [{log: deaf, within: 60 s}]}"


def test_a_run_with_all_expectations_met_exits_with_0_and_leaves_nothing(bench: Bench):
    bench.write(PATIENT)
    done = bench.smoke("--for=1", "--expect-process=patient", "--expect-clean-shutdown=60")
    assert done.returncode == 0, done.stdout
    assert ": 3 expectations with the implied 'no unexpected exits', observed for" in done.stdout
    assert "smoke: 3 of 3 expectations met" in done.stdout
    assert bench.report()["ending"]["left_processes"] == []


def test_an_expectation_that_is_not_met_exits_with_3_and_an_explanation(bench: Bench):
    bench.write(BRIEF)
    done = bench.smoke("--for=60", "--expect-log=brief: gone")
    assert done.returncode == 3
    assert "expected: a line from brief with 'gone'" in done.stdout
    assert "last lines of brief-1:" in done.stdout
    assert "here I was" in done.stdout


@pytest.mark.parametrize(
    ("action", "code"),
    [pytest.param(PATIENT, 0, marks=pytest.mark.thorough), (SHORT, 1)],
    ids=["met", "died"],
)
def test_exit_codes_are_known_where_sigchld_is_ignored(bench: Bench, action: str, code: int):
    bench.write(action)
    command = bench.command("--for=1", "--expect-log=.")
    done = subprocess.run(
        with_signals(command), env=bench.environment, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == code, done.stdout
    assert bench.report()["ending"]["returncode"] is not None


@pytest.fixture
def short_folder() -> Iterator[Path]:
    """For sockets, whose paths have a limit."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        yield Path(folder)


def test_without_a_control_socket_nothing_is_started(bench: Bench, short_folder: Path):
    sockets = short_folder / f"ros-launcher-{os.getuid()}"
    sockets.mkdir()
    sockets.chmod(0o755)
    bench.environment["TMPDIR"] = str(sockets.parent)
    bench.environment.pop("XDG_RUNTIME_DIR", None)
    bench.write(PATIENT)
    junit = bench.folder / "junit.xml"
    done = bench.smoke(f"--junit={junit}", "--expect-process=patient")
    problem = f"cannot open the control socket: {sockets} is accessible to other users"
    assert (done.returncode, done.stderr.count(problem)) == (1, 1), done
    assert "fix: chmod 700" in done.stderr
    assert "not met" not in done.stdout
    assert problem in junit.read_text(encoding="utf-8")
    assert not (bench.evidence / "launcher.out").exists()


@pytest.mark.thorough
def test_an_unexpected_exit_exits_with_1(bench: Bench):
    bench.write(DONE, SHORT)
    done = bench.smoke("--for=60", "--expect-log=done")
    assert done.returncode == 1
    assert "short-2 exited at" in done.stdout


@pytest.mark.thorough
def test_an_expected_exit_is_no_failure(bench: Bench):
    bench.write(DONE, SHORT)
    done = bench.smoke("--for=60", "--expect-process=short=3")
    assert done.returncode == 0, done.stdout


@pytest.mark.thorough
def test_a_system_that_fails_at_once(bench: Bench):
    bench.write(SHORT)
    done = bench.smoke("--for=60", "--expect-log=short: last words", "--expect-process=short")
    assert done.returncode == 3
    assert bench.outcomes()["log last words"] == "met"
    assert "ended at" in bench.judged("process short")["seen"]


def test_a_system_that_ends_well_before_its_time(bench: Bench):
    bench.write(DONE)
    done = bench.smoke("--for=60", "--expect-process=done=0")
    assert done.returncode == 0, done.stdout


def test_a_system_that_never_comes_up(bench: Bench):
    bench.write(PATIENT)
    done = bench.smoke("--for=60", NODE)
    assert done.returncode == 124
    assert "not ready after 1.0 s: giving up" in done.stdout


def test_a_node_that_nothing_can_still_start_ends_the_run_when_its_time_is_over(bench: Bench):
    bench.write(PATIENT)
    done = bench.smoke("--ready-within=600", NODE)
    assert done.returncode == 124
    assert (
        "not ready: 'node /nowhere' was not met within 1.0 s, and nothing else will be started:"
        " giving up" in done.stdout
    )


@pytest.mark.thorough
def test_a_node_that_a_timer_may_still_start_is_waited_for(bench: Bench):
    bench.write(PATIENT, f"TimerAction(period=300.0, actions=[{PATIENT}]),")
    done = bench.smoke("--ready-within=5", NODE)
    assert done.returncode == 124
    assert "not ready after 5.0 s: giving up" in done.stdout


def test_a_system_that_is_ready_late_is_watched_as_long_as_any_other(bench: Bench):
    bench.write(f"TimerAction(period=2.0, actions=[{PATIENT}]),")
    done = bench.smoke("--for=0.5", "--expect-process=patient", "--ready-within=60")
    assert done.returncode == 0, done.stdout
    steps = bench.report()["steps"]
    assert steps["ready"] >= 2.0 and steps["stop"] >= steps["ready"] + 0.5
    assert bench.report()["ending"]["left_processes"] == []


@pytest.mark.thorough
def test_processes_that_wait_for_others_belong_to_the_start(bench: Bench):
    bench.write('sh("x1", "sleep 2; echo go; exec sleep 1000"),', 'sh("x2", "exec sleep 1000"),')
    rules = "x1: {ready_when: {log: go}}\nx2: {after: x1}\n"
    (bench.folder / "tested.supervise.yaml").write_text(rules, encoding="utf-8")
    done = bench.smoke("--for=0.5")
    assert done.returncode == 0, done.stdout
    assert bench.report()["steps"]["ready"] >= 2.0


@pytest.mark.thorough
def test_a_launch_file_that_hangs_and_ignores_signals(bench: Bench):
    bench.launch_file.write_text(
        "import signal, time\n"
        "for signum in (signal.SIGINT, signal.SIGTERM):\n"
        "    signal.signal(signum, signal.SIG_IGN)\n"
        "while True:\n"
        "    time.sleep(1)\n",
        encoding="utf-8",
    )
    done = bench.smoke("--ready-within=10")  # by then it ignores the signals
    assert done.returncode == 124
    assert "the launcher did not exit and was killed" in done.stdout


@pytest.mark.thorough
def test_a_system_that_hangs_on_shutdown(bench: Bench):
    bench.write(DEAF)
    bench.expect(UNTIL_DEAF)
    done = bench.smoke("--expect-clean-shutdown=60", *IMPATIENT)
    assert done.returncode == 3
    assert "deaf-1 needed SIGKILL" in bench.judged("clean shutdown 60 s")["seen"]


@pytest.mark.thorough
def test_a_sigkill_at_the_stop_is_reported_without_an_expectation(bench: Bench):
    bench.write(DEAF)
    bench.expect(UNTIL_DEAF)
    done = bench.smoke(*IMPATIENT)
    assert done.returncode == 1
    assert re.search(
        r"^NOT MET +no process is killed at the stop +killed after .*: deaf-1",
        done.stdout,
        re.M,
    )


def test_a_bad_launch_file_exits_with_2_and_its_error(bench: Bench):
    bench.write("1 / 0,")
    path = bench.folder / "out.xml"
    done = bench.smoke("--for=1", f"--junit={path}")
    assert done.returncode == 2
    assert "tested.launch.py" in done.stderr and "ZeroDivisionError" in done.stderr
    assert "ZeroDivisionError: division by zero" in path.read_text(encoding="utf-8")


@pytest.mark.thorough
def test_an_artifacts_folder_that_cannot_be_created_exits_with_2(bench: Bench, tmp_path: Path):
    bench.write(DEAF)
    (tmp_path / "taken").write_text("", encoding="utf-8")
    done = bench.smoke("--for=1", f"--artifacts={tmp_path / 'taken'}")
    assert done.returncode == 2
    assert "--artifacts" in done.stderr and "File exists" in done.stderr


def test_an_interrupted_run_takes_its_system_along(bench: Bench):
    bench.write(PATIENT)
    run = bench.start("--for=60", "--expect-process=patient")
    assert run.stdout is not None
    told = ""
    while "ready" not in told:
        told = run.stdout.readline()
    launcher = next(bench.evidence.glob("log/*-*")).name.rpartition("-")[2]
    run.send_signal(signal.SIGTERM)
    run.communicate(timeout=120)
    assert run.returncode == 143
    assert processes_of(int(launcher)) == {}


def test_the_system_of_a_killed_run_is_stopped(bench: Bench):
    bench.write(PATIENT)
    run = bench.start("--for=60", "--expect-process=patient")
    wait_until(lambda: list(bench.evidence.glob("log/*-*/patient-1.log")), "the system is up")
    launcher = int(next(bench.evidence.glob("log/*-*")).name.rpartition("-")[2])
    run.kill()
    run.communicate(timeout=120)
    wait_until(lambda: not is_alive(launcher), "the launcher ends")
    wait_until(lambda: not processes_of(launcher), "everything of its run ends")


@pytest.mark.thorough
def test_a_reader_that_has_seen_enough_does_not_change_the_result(bench: Bench):
    bench.write(PATIENT)
    run = bench.start("--for=1", "--expect-log=never")
    assert run.stdout is not None
    run.stdout.readline()
    run.stdout.close()
    assert run.wait(timeout=120) == 3
    assert bench.outcomes()["log never"] == "violated"
