"""`smoke --record` on real systems, and the recorded files as expectations."""

from __future__ import annotations

import re
import signal
from pathlib import Path

import pytest

from launcher.smoke.preflight import loader
from tests.smoke.process.bench import DEAF, IMPATIENT, PATIENT, SHORT, Bench
from tests.support.repository import REPOSITORY
from tests.support.waiting import rest_of

ONCE = ("--repeat=1", "--for=1")
ERROR = 'sh("bad", "echo \'[ERROR] [bad]: no map\'; exec sleep 1000"),'
SETUP = 'sh("setup", "echo prepared"),'


@pytest.fixture
def path(bench: Bench) -> Path:
    return bench.folder / "recorded.yaml"


@pytest.mark.thorough
def test_a_recorded_file_is_met_by_the_next_run_and_never_replaced(bench: Bench, path: Path):
    bench.write(SETUP, PATIENT)
    # Long enough that `setup` exits early in it, on a busy machine as well.
    done = bench.smoke(f"--record={path}", "--repeat=1", "--for=3", "sigterm_timeout:=4")
    assert done.returncode == 0, done.stdout + done.stderr
    text = path.read_text(encoding="utf-8")
    assert "- {log: here I am, process: patient, within: " in text
    assert "- {process: setup, exits: 0}" in text and "process: patient, alive: true" in text
    assert "arguments: {sigterm_timeout: '4'}" in text
    # Longer where a process began late, on a busy machine.
    (for_s,) = re.findall(r"^for: (\d+) s$", text, re.MULTILINE)
    assert int(for_s) >= 3

    again = bench.smoke(f"--record={path}", *ONCE)
    assert again.returncode == 2
    assert f"--record {path}: the file exists" in again.stderr
    assert "--force replaces it" in again.stderr
    assert path.read_text(encoding="utf-8") == text

    checked = bench.smoke(f"--expect={path}")
    assert checked.returncode == 0, checked.stdout


@pytest.mark.parametrize(
    ("action", "code", "reason"),
    [
        (SHORT, 1, "short-1 exited at"),
        pytest.param(ERROR, 1, "no map", marks=pytest.mark.thorough),
        pytest.param(DEAF, 1, "no process is killed at the stop", marks=pytest.mark.thorough),
    ],
    ids=["exit", "error", "killed"],
)
def test_a_run_that_is_not_healthy_is_not_recorded(
    bench: Bench, path: Path, action: str, code: int, reason: str
):
    bench.write(action)
    done = bench.smoke(f"--record={path}", *ONCE, *IMPATIENT)
    assert done.returncode == code, done.stdout + done.stderr
    assert reason in done.stdout
    assert f"error: nothing was recorded in {path}: run 1 was not healthy" in done.stderr
    assert not [one for one in bench.folder.iterdir() if "recorded" in one.name]


@pytest.mark.thorough
def test_a_process_that_does_not_start_in_time_is_named(bench: Bench, path: Path):
    """A launch file that starts less than it seems to at its start."""
    absent = PATIENT.replace('patient"', 'absent"').replace("),", ", condition=IfCondition(GO)),")
    bench.write(
        'SetEnvironmentVariable("GO", "1"),',
        'TimerAction(period=0.1, actions=[SetEnvironmentVariable("GO", "0")]),',
        f"TimerAction(period=0.5, actions=[{absent}]),",
        PATIENT,
    )
    head = """
from launch.actions import SetEnvironmentVariable
from launch.conditions import IfCondition
from launch.substitutions import EnvironmentVariable

GO = EnvironmentVariable("GO")
"""
    bench.launch_file.write_text(head + bench.launch_file.read_text())
    done = bench.smoke(f"--record={path}", *ONCE, "--ready-within=5")
    assert done.returncode == 124, done.stdout
    assert "not ready after 5.0 s; not started: absent" in done.stdout
    assert not path.exists()


@pytest.mark.thorough
def test_an_interrupted_recording_leaves_nothing(bench: Bench, path: Path):
    bench.write(PATIENT)
    run = bench.start(f"--record={path}", "--for=60")
    assert run.stdout is not None
    told = ""
    while "started" not in told:
        told = run.stdout.readline()
    run.send_signal(signal.SIGINT)
    told, _ = rest_of(run, 120)
    assert run.returncode == 130
    assert "nothing was recorded" in told and "interrupted" in told
    assert not path.exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--expect-log=x",), "--record excludes --expect-log"),
        (("--expect=x.yaml",), "--record excludes --expect"),
        (("--chaos=kill one of a every 1 s",), "--record excludes --chaos"),
        (("--for=0",), "nothing can be observed in 0 s"),
    ],
)
def test_options_that_a_recording_cannot_have_are_refused(
    bench: Bench, path: Path, words: tuple[str, ...], told: str
):
    bench.write(PATIENT)
    done = bench.smoke(f"--record={path}", *words)
    assert done.returncode == 2
    assert told in done.stderr
    assert not path.exists()


@pytest.mark.thorough
def test_the_fleet_is_recorded_from_a_single_run(bench: Bench, path: Path):
    bench.launch_file = REPOSITORY / "launch" / "system.launch.py"
    done = bench.smoke(f"--record={path}", "--for=6", "--repeat=1", "enable_debug:=true")
    assert done.returncode == 0, done.stdout + done.stderr
    text = path.read_text(encoding="utf-8")
    for part in ("node: /robot_3", "qos: /fleet/status"):
        assert part in text
    by_subject = {(e.kind, e.subject): e for e in loader.load(str(path)).expectations}
    # A robot that comes late on a busy machine says so, which it may not in the next run.
    path.write_text(re.sub(r"^- \{log: Backlog.*\n", "", text, flags=re.MULTILINE), "utf-8")
    # Not always "1 Hz": on a busy machine the first or the last task is some hundredths late.
    assert 1.0 in by_subject["rate", "/fleet/tasks"].get("is")
    checked = bench.smoke(f"--expect={path}")
    assert checked.returncode == 0, checked.stdout
    log = (bench.evidence / "launch.log").read_text(encoding="utf-8")
    assert "robot_3 is reporting" in log
    assert "has not reported" not in log  # in a normal start, although robot_3 comes late


@pytest.mark.thorough
def test_ten_nodes_are_recorded_without_what_differs_between_runs(bench: Bench, path: Path):
    bench.launch_file = REPOSITORY / "tests/smoke/process/ten_nodes.launch.py"
    done = bench.smoke(f"--record={path}", "--for=8")
    assert done.returncode == 0, done.stdout + done.stderr
    script = loader.load(str(path))
    subjects = {
        (e.kind, str(getattr(e.subject, "pattern", e.subject))) for e in script.expectations
    }
    assert sum(kind == "node" for kind, _ in subjects) == 10
    assert subjects >= {
        *(("node", "/anonymous_*"), ("node", "/site/late"), ("process", "prepare")),
        *(("rate", "/steady"), ("rate", "/fast"), ("rate", "/site/late"), ("rate", "/beats")),
        *(("message", "/map"), ("qos", "/shared"), ("qos", "/fast")),
        *(("service", "/switch"), ("service", "/switch/reset"), ("service", "/engine/get_state")),
        *(("log", "steady is ready"), ("log", "switch started with pid")),
    }
    for never in (("rate", "/moods"), ("rate", "/map"), ("topic", "/rosout")):
        assert never not in subjects
    assert not [name for _, name in subjects if name.startswith("/private_")]

    checked = bench.smoke(f"--expect={path}")
    assert checked.returncode == 0, checked.stdout
