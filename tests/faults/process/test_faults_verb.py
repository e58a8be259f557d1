"""`faults` in a shell, of a run whose watcher reports what the test says."""

from __future__ import annotations

import functools
import json
import os
import signal
from collections.abc import Iterator

import psutil
import pytest

from launcher.control.fault_texts import NOT_WATCHING
from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun
from tests.support.json_forms import fit
from tests.support.waiting import wait_until
from tests.support.watcher_stand_in import IN_PLACE, Reports

STAND_IN = "watcher_stand_in"


@pytest.fixture
def reports(control_bench: ControlBench) -> Reports:
    made = Reports(control_bench.folder)
    control_bench.env.update(made.env)
    return made


@pytest.fixture
def watched(control_bench: ControlBench, reports: Reports) -> Iterator[ControlledRun]:
    """A watched run with the process `cat-1`."""
    actions = f'{IN_PLACE} sh("exec cat", name="cat")'
    with control_bench.launch(actions, "--watchful") as run:
        yield run


def has_fault(run: ControlledRun, name: str) -> bool:
    return any(one["fault"] == name for one in run.ask("faults")["faults"])


def test_the_table_the_document_and_the_exit_code(watched: ControlledRun, reports: Reports):
    wait_until(lambda: "faults" in watched.row("cat"), "the part that watches")
    assert watched.shell("faults", "--check").stdout == "no fault\n"
    reports.write({"left": [{"expectation": "it ends", "why": "its end is needed"}]})
    reports.fault("confirmed", name="no status", follows="robot_1 reports", cause=None)
    reports.fault("confirmed")
    wait_until(lambda: has_fault(watched, "robot_1 reports"), "the fault")

    head, first, second, left = watched.shell("faults").stdout.splitlines()
    assert head.split() == ["state", "fault", "since", "seen", "cause"]
    assert first.startswith("active  robot_1 reports")
    assert first.endswith("no message for 3.0 s  cat-1 was killed (SIGKILL)")
    assert second.startswith("active    no status")
    assert left == "left to smoke, its end is needed: it ends"
    (document,) = fit("faults", watched.shell("faults", "--json").stdout)
    assert [one["fault"] for one in document["faults"]] == ["no status", "robot_1 reports"]
    assert watched.shell("faults", "--check").returncode == 1
    assert watched.row("cat")["faults"] == ["no status", "robot_1 reports"]
    assert "  no status +1  " in watched.shell("ps").stdout
    assert "faults       no status\n" in watched.shell("info", "cat").stdout

    for name in ("no status", "robot_1 reports"):
        answer = watched.shell("faults", "--mute", name, "--for", "60", "--reason", "tests")
        assert f"muted: {name}" in answer.stdout, answer.stderr
    assert watched.shell("faults", "--check").returncode == 0
    assert "faults" not in watched.shell("ps").stdout
    answer = watched.shell("faults", "--mute", "robot_1 report")
    assert (answer.returncode, answer.stderr.splitlines()[1]) == (
        2,
        "hint: did you mean 'robot_1 reports'?",
    )


def test_changes_are_followed_until_ctrl_c(watched: ControlledRun, reports: Reports):
    wait_until(lambda: "faults" in watched.row("cat"), "the part that watches")
    reports.fault("suspected", state="suspected", confirmed_s=None)
    wait_until(lambda: has_fault(watched, "robot_1 reports"), "the fault")
    texts = watched.shell_start("faults", "-f")
    lines = watched.shell_start("faults", "-f", "--json")
    assert " suspected: robot_1 reports: " in texts.stdout.readline()
    assert json.loads(lines.stdout.readline())["change"] == "present"
    reports.fault("updated", state="suspected", confirmed_s=None, seen="no message for 3.1 s")
    reports.fault("confirmed")
    assert " confirmed: robot_1 reports: " in texts.stdout.readline()
    heads = [lines.stdout.readline() for _ in range(2)]
    assert [json.loads(one)["change"] for one in heads] == ["updated", "confirmed"]
    for follower in (texts, lines):
        follower.send_signal(signal.SIGINT)
        assert follower.communicate(timeout=60) == ("", "")
        assert follower.returncode == 0
    fit("faults --follow", "".join(heads))


def test_a_run_that_is_not_watched_is_an_error_with_a_hint(run: ControlledRun):
    answer = run.shell("faults")

    assert answer.returncode == 1
    assert answer.stderr == (
        "error: this run is not watched\n"
        "hint: start the run with --watchful, or with --expect FILE\n"
    )


def test_all_mistakes_in_the_file_beside_are_refused_before_anything_starts(
    control_bench: ControlBench,
):
    file, proof = control_bench.folder / "bench.expect.yaml", control_bench.folder / "started"
    file.write_text("expect:\n  - clean_shutdown: true\n  - rat: /x\n")
    done = control_bench.run(f'sh("touch {proof}", name="one")', "--watchful")

    assert done.returncode == 2 and not proof.exists()
    errors = done.stderr.decode()
    assert f"{file}:2: invalid time" in errors and "did you mean 'rate'?" in errors


def test_mistakes_that_the_watcher_finds_are_shown_once(watched: ControlledRun, reports: Reports):
    wait_until(lambda: "faults" in watched.row("cat"), "the part that watches")
    reports.write({"mistake": "a.expect.yaml:2: invalid time"})
    watched.wait_for("the run is not watched:\n")
    assert watched.screen.count("a.expect.yaml:2: invalid time") == 1


def test_what_was_not_seen_yet_is_muted_and_mutes_are_listed(
    watched: ControlledRun, reports: Reports
):
    wait_until(lambda: "faults" in watched.row("cat"), "the part that watches")
    mutes = {"old": {"reason": "x", "until_s": None}, "past": {"reason": None, "until_s": 1.0}}
    reports.write({"left": [{"expectation": "it ends", "why": "its end is needed"}]})
    reports.write({"names": ["old", "rate /t", "disk: *"], "counts": [2, 1], "mutes": mutes})
    watched.wait_for("watching: 1 of every run; 1 left to smoke")
    watched.wait_for("muted since an earlier run: old (`faults` lists them)")
    for name in ("rate /t", "disk: /log"):
        answer = watched.shell("faults", "--mute", name, "--for", "2min")
        assert answer.stdout == f"muted: {name}, which was not seen yet\n", answer.stderr
    assert watched.shell("faults", "--unmute", "old").returncode == 0
    assert watched.shell("faults", "--mute", "disk").returncode == 2
    text, document = watched.shell("faults").stdout, watched.shell("faults", "--json").stdout
    assert "no fault\nmuted: disk: /log until " in text and "old" not in text
    fit("faults", document)
    assert [one["fault"] for one in json.loads(document)["mutes"]] == ["disk: /log", "rate /t"]


def test_a_check_that_cannot_know_is_no_fault_and_not_all_is_well(
    watched: ControlledRun,
):
    wait_until(lambda: "faults" in watched.row("cat"), "the part that watches")
    assert watched.shell("faults", "--check", "--run", "nobody").returncode == 2
    for end in ("restarting it", "restarting it", "the run continues without it"):
        wait_until(lambda: watcher_of(watched), "the watcher")
        (pid,) = watcher_of(watched)
        os.kill(pid, signal.SIGKILL)
        wait_until(functools.partial(is_gone, pid), "its end")
        watched.wait_for(end)
    answer = watched.shell("faults", "--check")
    assert answer.returncode == 2
    assert answer.stdout == f"{NOT_WATCHING}\n"


def is_gone(pid: int) -> bool:
    return not psutil.pid_exists(pid)


def watcher_of(run: ControlledRun) -> list[int]:
    children = psutil.Process(run.process.pid).children()
    return [one.pid for one in children if STAND_IN in " ".join(one.cmdline())]
