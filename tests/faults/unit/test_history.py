"""The history of faults over runs: `faults.sqlite`."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from launcher.base.errors import LauncherError
from launcher.faults.history import database, listing, writing
from launcher.faults.history.reading import histories, summaries
from launcher.faults.history.versions import FilesVersion, described, of_launch
from launcher.faults.history.writing import FaultHistory
from tests.support import watcher_stand_in
from tests.support.json_forms import fit
from tests.support.verbs import in_process
from tests.support.waiting import wait_until

TARGET = "/ws/system.launch.py"
NOW_S = time.time()


def fault(name: str = "robot_1 reports", count: int = 1, **more: Any) -> dict[str, Any]:
    at_s = more.pop("at_s", NOW_S)
    times = {"first_s": at_s, "confirmed_s": at_s + 1, "last_s": at_s + 2}
    unexplained = {"cause": None, "rule": None, "seen": "nothing"}
    return {**watcher_stand_in.fault(name, count=count), **times, **unexplained, **more}


def begun(folder: Path, run: str, notes: list[str], **more: Any) -> FaultHistory:
    history = FaultHistory(str(folder), notes.append)
    version = more.pop("version", FilesVersion("ab" * 32, "v1-2-gabc"))
    settings = {
        "target": TARGET,
        "started_s": NOW_S,
        "version_of": lambda: version,
        "launcher": "1.0",
        "log_dir": str(folder / run),
        **more,
    }
    history.begin_run(run=run, **settings)
    return history


def write(folder: Path, run: str, *faults: dict[str, Any], **more: Any) -> None:
    notes: list[str] = []
    history = begun(folder, run, notes, **more)
    for one in faults:
        history.record(one)
    history.end_run()
    assert notes == []


def test_since_when_how_often_and_in_which_versions(tmp_path: Path):
    old, new = FilesVersion("a" * 64, None), FilesVersion("b" * 64, "v2")
    write(tmp_path, "1", fault(cause="robot_1 died"), version=old, started_s=NOW_S)
    write(
        tmp_path,
        "2",
        fault(at_s=NOW_S + 100),
        fault(count=2, at_s=NOW_S + 200),
        version=new,
        started_s=NOW_S + 90,
    )
    write(tmp_path, "3", version=new, started_s=NOW_S + 300)
    write(tmp_path, "other", fault("x"), target="/ws/other.launch.py")

    (found,) = summaries(str(tmp_path), TARGET)

    assert (found.fault, found.times, found.runs, found.runs_since) == ("robot_1 reports", 3, 2, 1)
    assert (found.since_s, found.last_s) == pytest.approx((NOW_S, NOW_S + 202))
    assert (found.first_version, found.last_version, found.versions) == (old, new, 2)
    assert found.cause == "robot_1 died"


def test_one_row_for_each_time_that_it_was_confirmed(tmp_path: Path):
    suspected = fault(confirmed_s=None)
    healed = fault(healed_s=NOW_S + 9, last_s=NOW_S + 5)
    write(tmp_path, "1", suspected, fault(), fault(last_s=NOW_S + 4), healed)

    (found,) = summaries(str(tmp_path), TARGET)

    assert (found.times, found.last_s) == (1, pytest.approx(NOW_S + 5))


def test_a_fault_that_comes_and_goes_has_a_bounded_number_of_rows(tmp_path: Path):
    faults = [fault(count=count, at_s=NOW_S + count) for count in range(1, 1001)]
    write(tmp_path, "1", *faults)

    (found,) = summaries(str(tmp_path), TARGET)

    assert (found.times, found.since_s) == (1000, pytest.approx(NOW_S + 1))
    with sqlite3.connect(tmp_path / database.FILE) as opened:
        assert opened.execute("SELECT count(*) FROM faults").fetchone()[0] <= 101


def test_old_runs_are_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(writing, "KEEP_RUNS", 3)
    for number in range(5):
        write(tmp_path, str(number), fault(), started_s=NOW_S + number)
    monkeypatch.setattr(writing, "KEEP_RUNS", 1000)
    monkeypatch.setattr(writing, "KEEP_ROWS", 2)
    write(tmp_path, "last", started_s=NOW_S + 9)

    (found,) = summaries(str(tmp_path), TARGET)
    assert found.runs == 2
    with sqlite3.connect(tmp_path / database.FILE) as opened:
        assert opened.execute("SELECT count(*) FROM faults").fetchone()[0] == 2


def test_mutes_hold_for_later_runs_of_the_target(tmp_path: Path):
    notes: list[str] = []
    later_s = time.time() + 1000
    history = begun(tmp_path, "1", notes)
    history.set_mute(TARGET, "a", "is known", None)
    history.set_mute(TARGET, "b", None, NOW_S - 1)
    history.set_mute(TARGET, "c", "for now", later_s)
    history.set_mute("/other", "d", None, None)
    history.end_run()

    again = begun(tmp_path, "2", notes)
    found = again.mutes_of(TARGET)
    assert found == {
        "a": {"reason": "is known", "until_s": None},
        "c": {"reason": "for now", "until_s": later_s},
    }
    again.clear_mute(TARGET, "a")
    again.end_run()
    assert list(again.mutes_of(TARGET)) == ["c"]
    assert notes == []


NEWER = f"PRAGMA application_id={database.APPLICATION}; PRAGMA user_version=9"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"no database " * 500, "not a database"),
        ("CREATE TABLE x (y)", "of another program"),
        (NEWER, "a newer launcher"),
    ],
)
def test_a_file_that_is_no_history_is_left_alone_with_one_note(
    tmp_path: Path, content: bytes | str, message: str
):
    path = tmp_path / database.FILE
    if isinstance(content, str):
        with sqlite3.connect(path) as opened:
            opened.executescript(content)
    else:
        path.write_bytes(content)
    before = path.read_bytes()
    notes: list[str] = []

    history = begun(tmp_path, "1", notes)
    assert history.mutes_of(TARGET) == {}
    for count in range(100):
        history.record(fault(count=count))
    history.end_run()

    assert len(notes) == 1 and message in notes[0]
    assert path.read_bytes() == before
    with pytest.raises(LauncherError, match=message):
        listing.show({"ROS_LOG_DIR": str(tmp_path)})


def test_a_folder_that_cannot_be_written_costs_the_history_only(tmp_path: Path):
    notes: list[str] = []
    history = begun(tmp_path / "absent", "1", notes)
    for number in range(20_000):
        history.record(fault(f"fault {number}"))
    history.end_run()

    assert len(notes) == 1 and "unable to open" in notes[0]


def test_what_another_run_is_writing_is_waited_for_without_holding_up_the_watcher(tmp_path: Path):
    write(tmp_path, "1")
    with sqlite3.connect(tmp_path / database.FILE, isolation_level=None) as opened:
        opened.execute("BEGIN IMMEDIATE")
        notes: list[str] = []
        history = begun(tmp_path, "2", notes)
        before_s = time.thread_time()
        for number in range(1000):
            history.record(fault(f"fault {number}"))
        assert time.thread_time() - before_s < 0.5
        opened.execute("COMMIT")
    history.end_run()

    assert (len(summaries(str(tmp_path), TARGET)), notes) == (1000, [])


def test_what_cannot_be_written_at_the_end_of_a_run_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(writing, "CLOSE_S", 0.1)
    write(tmp_path, "1")
    with sqlite3.connect(tmp_path / database.FILE, isolation_level=None) as opened:
        opened.execute("BEGIN IMMEDIATE")
        notes: list[str] = []
        history = begun(tmp_path, "2", notes)
        history.end_run()
        assert len(notes) == 1 and notes[0].endswith("not written within 0.1 s")
        opened.execute("COMMIT")
    wait_until(lambda: histories(str(tmp_path))[0].runs == 2, "the rest is written")


def test_a_run_that_has_always_something_to_write_leaves_turns_to_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(writing, "PAUSE_S", 60.0)
    transactions: list[object] = []
    write_one = FaultHistory._write
    monkeypatch.setattr(
        FaultHistory, "_write", lambda *all_: (transactions.append(all_), write_one(*all_))
    )
    notes: list[str] = []
    history = begun(tmp_path, "1", notes)
    wait_until(lambda: transactions, "the first transaction")
    for number in range(100):
        history.record(fault(f"fault {number}"))
        time.sleep(0.001)
    history.end_run()

    assert len(transactions) == 2  # at its begin, and at its end, which does not wait
    assert (len(summaries(str(tmp_path), TARGET)), notes) == (100, [])


WRITER = """
import itertools, sys, time
from pathlib import Path
from tests.faults.unit.test_history import begun, fault
notes = []
history = begun(Path(sys.argv[1]), sys.argv[2], notes)
for number in itertools.count(1):
    history.record(fault(f"fault {number % 50}", count=number))
    if number % 100 == 0:
        print(number, *notes, flush=True)
    if number % 10 == 0:
        time.sleep(0.001)  # so that it leaves the thread that writes some time
    if number == int(sys.argv[3]):
        break
history.end_run()
print("notes", notes)
"""


def writer(folder: Path, run: str, rows: int) -> subprocess.Popen[str]:
    words = [sys.executable, "-c", WRITER, str(folder), run, str(rows)]
    return subprocess.Popen(words, stdout=subprocess.PIPE, text=True)


def test_several_runs_write_and_one_is_killed_meanwhile(tmp_path: Path):
    killed = writer(tmp_path, "killed", -1)
    others = [writer(tmp_path, f"run {number}", 3000) for number in range(2)]
    assert killed.stdout is not None
    killed.stdout.readline()
    wait_until(lambda: [one for one in histories(str(tmp_path)) if one.runs == 3], "three runs")
    killed.kill()
    killed.wait()
    ends = [other.communicate()[0].splitlines()[-1] for other in others]
    write(tmp_path, "last", fault("the last"))

    assert ends == ["notes []"] * 2
    (found,) = histories(str(tmp_path))
    assert found.runs == 4
    with sqlite3.connect(tmp_path / database.FILE) as opened:
        assert opened.execute("PRAGMA integrity_check").fetchone() == ("ok",)


HOSTILE = "x\0\x1b[31m\ud800<b>'; DROP TABLE runs; --\n" + "y" * 10_000


def test_hostile_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    write(tmp_path, "1", fault(HOSTILE, seen=HOSTILE, cause=HOSTILE), target=HOSTILE)

    assert listing.show({"ROS_LOG_DIR": str(tmp_path)}) == 0
    shown = capsys.readouterr().out
    assert "\x1b" not in shown and "\0" not in shown and len(shown.splitlines()) == 3
    assert listing.show({"ROS_LOG_DIR": str(tmp_path)}, as_json=True) == 0
    (target,) = json.loads(capsys.readouterr().out)["targets"]
    assert target["faults"][0]["times"] == 1


def test_the_listing(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    env = {"ROS_LOG_DIR": str(tmp_path)}
    assert listing.show(env) == 0
    assert "no run was watched" in capsys.readouterr().out
    write(tmp_path, "1", fault(cause="robot_1-2 died"))
    write(tmp_path, "2", started_s=NOW_S + 10)

    assert listing.show(env, "system") == 0
    head, columns, row = capsys.readouterr().out.splitlines()
    assert head.startswith(f"{TARGET}: 2 runs since ")
    assert columns.split("  ")[0] == "FAULT"
    assert "1 of 2, not in the last 1" in row and row.endswith("robot_1-2 died")
    assert "abababab v1-2-gabc" in row and "the same" in row
    with pytest.raises(LauncherError, match=r"no run of 'sistem\.launch\.py'"):
        listing.show(env, "sistem.launch.py")


def test_the_verb_shows_the_history(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    write(tmp_path, "1", fault(cause="robot_1-2 died"))

    assert "robot_1-2 died" in in_process("faults", "--all-runs", "system").out
    (document,) = fit("faults --all-runs", in_process("faults", "--all-runs", "--json").out)
    assert [one["times"] for one in document["targets"][0]["faults"]] == [1]
    mixed = in_process("faults", "--all-runs", "-f")
    assert (mixed.code, mixed.err) == (2, "error: --all-runs and -f exclude each other\n")
    assert in_process("faults", "system").code == 2


def test_the_version_of_a_launch_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    launch, other = tmp_path / "a.launch.py", tmp_path / "b.yaml"
    launch.write_text("1")
    other.write_text("2")
    alone = of_launch(str(launch))
    both = of_launch(str(launch), [str(other), "/absent", "/dev/zero"])
    other.write_text("3")
    changed = of_launch(str(launch), [str(other)])

    assert len({alone.files_hash, both.files_hash, changed.files_hash}) == 3
    assert of_launch("/absent/x.py") == FilesVersion(None, None)
    if alone.git is None:  # /tmp may be in a repository
        subprocess.run(["git", "init", "-q", tmp_path], check=True)
        who = ("-c", "user.name=a", "-c", "user.email=a@b.c")
        words = ["git", *who, "-C", tmp_path, "commit", "-qm", "x", "--allow-empty"]
        subprocess.run(words, check=True)
        assert len(of_launch(str(launch)).git or "") >= 7
    hanging = tmp_path / "bin"
    hanging.mkdir()
    (hanging / "git").write_text("#!/bin/sh\nsleep 100 & wait\n")
    (hanging / "git").chmod(0o755)
    monkeypatch.setenv("PATH", f"{hanging}:{os.environ['PATH']}")
    assert described(str(tmp_path), timeout_s=0.1) is None
