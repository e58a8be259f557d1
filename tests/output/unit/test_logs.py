"""The files of a run: bounded, pruned, and without colour."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.base.model.run_events import Finished, Stopping
from launcher.base.model.spec import OutputPolicy
from launcher.output.lines import with_prefix
from launcher.output.logs.old_runs import holds_evidence, kept_beyond, prune
from launcher.output.logs.rotating_file import RotatingFile
from launcher.output.logs.run_directory import (
    EVENTS,
    FLOOD_BYTES,
    MAX_TOGETHER,
    RunDirectory,
    new_run_path,
)


def test_a_file_makes_room_before_it_grows_over_its_limit(tmp_path: Path):
    file = RotatingFile(f"{tmp_path}/a.log", limit_bytes=100, backups=2)
    for number in range(50):
        file.append(b"%02d" % number * 20)
    file.close()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.log", "a.log.1", "a.log.2"]
    assert all(p.stat().st_size <= 100 for p in tmp_path.iterdir())
    kept = b"".join((tmp_path / n).read_bytes() for n in ("a.log.2", "a.log.1", "a.log"))
    assert kept == b"".join(b"%02d" % number * 20 for number in range(45 - 1, 50))


def path_of(folder: RunDirectory) -> Path:
    assert folder.path is not None
    return Path(folder.path)


def folder_in(path: Path) -> RunDirectory:
    return RunDirectory(new_run_path({"ROS_LOG_DIR": str(path)}), pytest.fail)


def test_the_file_of_a_process_gets_what_the_screen_has_got(tmp_path: Path, monkeypatch):
    written: list[bytes] = []
    monkeypatch.setattr(RotatingFile, "append", lambda file, *blocks: written.extend(blocks))
    folder = folder_in(tmp_path)
    block = b"one\ntwo\n"
    shown = with_prefix(b"[a-1] ", block)
    folder.write_lines("a-1", OutputPolicy(), "stdout", block)
    assert any(one is shown for one in written), "it was prefixed again"
    folder.close()


def test_names_of_runs_are_in_the_order_of_time_across_the_end_of_a_second():
    second_ns = 1_795_335_647 * 10**9
    times_ns = (second_ns - 1000, second_ns, second_ns + 1000)
    paths = [new_run_path({"ROS_LOG_DIR": "/log"}, now_ns) for now_ns in times_ns]
    names = [os.path.basename(path) for path in paths]
    assert names == sorted(set(names))
    assert [name[20:26] for name in names] == ["999999", "000000", "000001"]


def pruned(last: RunDirectory, *, keep: int) -> None:
    for _ in prune(str(path_of(last)), keep):
        pass


def test_the_latest_run_has_a_link_and_old_runs_are_pruned(tmp_path: Path):
    runs = []
    for _ in range(6):
        folder = folder_in(tmp_path)
        folder.close()
        runs.append(path_of(folder))
    last = folder_in(tmp_path)
    pruned(last, keep=3)
    assert (tmp_path / "latest").resolve() == path_of(last)
    assert [run.exists() for run in runs] == [False] * 4 + [True] * 2
    last.close()


def test_pruning_follows_no_link(tmp_path: Path):
    others = tmp_path / "others"
    (others / "inner").mkdir(parents=True)
    (others / "inner" / "file").touch()
    old = tmp_path / "2020-01-01-00-00-00-000001-host-1"
    (old / "deep" / "deeper").mkdir(parents=True)
    for folder in (old, old / "deep"):
        (folder / EVENTS).touch()
        (folder / "link").symlink_to(others)
        (folder / "nowhere").symlink_to(tmp_path / "nowhere")
    last = folder_in(tmp_path)
    pruned(last, keep=1)
    assert not old.exists()
    assert (others / "inner" / "file").exists()
    last.close()


def test_a_run_that_goes_on_and_a_folder_that_is_not_ours_are_not_pruned(tmp_path: Path):
    running = folder_in(tmp_path)
    foreign = tmp_path / "2020-01-01-00-00-00-000000-host-1"
    foreign.mkdir()
    lost = tmp_path / "2020-01-01-00-00-00-000001-host-1"
    lost.mkdir()
    (lost / EVENTS).touch()
    last = folder_in(tmp_path)
    pruned(last, keep=1)
    assert path_of(running).exists()
    assert foreign.exists()
    assert not lost.exists()
    running.close()
    last.close()


def test_a_run_that_goes_on_is_not_pruned_after_its_events_were_rotated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(RotatingFile.__init__, "__kwdefaults__", {"limit_bytes": 200, "backups": 1})
    running, last = folder_in(tmp_path), folder_in(tmp_path)
    for _ in range(9):
        running.events.note(Stopping("x" * 100))
        running.events.flush()
    running.keep_up()
    pruned(last, keep=1)
    assert path_of(running).exists()
    running.events.note(Finished(0))
    running.close()
    pruned(last, keep=1)
    assert not path_of(running).exists()
    last.close()


STARTED = '{"wall_s": 1.0, "monotonic_s": 1.0, "event": "started", "process": "a-1", "pid": 7}\n'
FINISHED = '{"wall_s": 1.0, "monotonic_s": 1.0, "event": "finished", "exit_code": %s}\n'


@pytest.mark.parametrize(
    ("events", "is_kept"),
    [
        (STARTED + FINISHED % "0", False),
        ("", False),  # nothing was started
        (STARTED + FINISHED % "1", True),
        (FINISHED % "130", True),
        (FINISHED % '0, "deaths": 2', True),  # restarted
        (STARTED, True),  # its launcher was killed
        (FINISHED[:-20], True),
        ("[1]\n", True),
        ('{"event": "note", "x": "%s"}\n' % ("x" * 9999), True),
    ],
)
def test_runs_that_hold_evidence_are_never_pruned(tmp_path: Path, events: str, is_kept: bool):
    old = folder_in(tmp_path)
    old.close()
    (path_of(old) / EVENTS).write_text(events)
    last = folder_in(tmp_path)
    for _ in range(2):
        pruned(last, keep=1)
        assert path_of(old).exists() is is_kept
    assert kept_beyond(str(tmp_path), 1) == [str(path_of(old))] * is_kept
    last.close()


@pytest.mark.parametrize("recording", ["snapshots", "bag"])
def test_runs_that_were_recorded_are_never_pruned(tmp_path: Path, recording: str):
    old = folder_in(tmp_path)
    old.events.note(Finished(0))
    old.close()
    assert not holds_evidence(str(path_of(old)))
    (path_of(old) / recording).mkdir()
    last = folder_in(tmp_path)
    pruned(last, keep=1)
    assert path_of(old).exists()
    last.close()


def test_old_runs_are_pruned_one_in_each_step(tmp_path: Path):
    runs = [folder_in(tmp_path) for _ in range(4)]
    for run in runs:
        run.close()
    last = folder_in(tmp_path)
    left = []
    for _ in prune(str(path_of(last)), 2):
        left.append(sum(path_of(run).exists() for run in runs))
    assert left == [3, 2, 1]
    last.close()


def test_everything_is_in_the_merged_file_and_in_the_process_s_own(tmp_path: Path):
    folder = folder_in(tmp_path)
    screen = OutputPolicy.named("screen")
    folder.write_lines("talker-1", screen, "both", b"\x1b[31mred\x1b[0m\nplain\n")
    folder.write_lines("talker-1", OutputPolicy.named("own_log"), "stderr", b"err\n")
    folder.close()
    lines = (path_of(folder) / "launch.log").read_text().splitlines()
    assert [line.partition(" ")[2] for line in lines] == [
        "[talker-1] red",
        "[talker-1] plain",
        "[talker-1] err",
    ]
    assert (path_of(folder) / "talker-1.log").read_text().count("\n") == 3
    assert (path_of(folder) / "talker-1-stderr.log").read_text() == "[talker-1] err\n"


def test_a_full_disk_is_reported_once(tmp_path: Path):
    said: list[str] = []
    folder = RunDirectory(f"{tmp_path}/run", said.append)
    os.symlink("/dev/full", path_of(folder) / "launch.log")
    for _ in range(3):
        folder.log("INFO", "launch", "hello")
    folder.close()
    assert said == [f"no log files from here on: No space left on device: {folder.path}"]


def test_a_folder_with_the_name_of_the_link_only_prevents_the_link(tmp_path: Path):
    (tmp_path / "latest").mkdir()
    said: list[str] = []
    folder = RunDirectory(new_run_path({"ROS_LOG_DIR": str(tmp_path)}), said.append)
    folder.log("INFO", "launch", "hello")
    folder.close()
    assert said == [f"cannot link {tmp_path / 'latest'}: Is a directory"]
    assert "hello" in (path_of(folder) / "launch.log").read_text()
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted([path_of(folder).name, "latest"])


@pytest.mark.parametrize("is_made_by_a_node", [False, True])
def test_a_removed_folder_is_created_again_and_reported_once(
    tmp_path: Path, is_made_by_a_node: bool
):
    said: list[str] = []
    folder = RunDirectory(new_run_path({"ROS_LOG_DIR": str(tmp_path / "log")}), said.append)
    folder.log("INFO", "launch", "before")
    folder.keep_up()
    assert said == []
    shutil.rmtree(tmp_path / "log")
    if is_made_by_a_node:
        path_of(folder).mkdir(parents=True)
    for _ in range(2):
        folder.keep_up()
        folder.log("INFO", "launch", "after")
    pruned(folder, keep=1)
    folder.close()
    assert len(said) == 1 and f"{folder.path} was removed" in said[0]
    lines = (path_of(folder) / "launch.log").read_text().splitlines()
    assert [line.rpartition("]: ")[2] for line in lines] == [said[0], "after", "after"]
    assert (path_of(folder).parent / "latest" / EVENTS).is_file()


def test_a_folder_that_cannot_be_created_again_is_reported_once(tmp_path: Path):
    said: list[str] = []
    folder = RunDirectory(new_run_path({"ROS_LOG_DIR": str(tmp_path / "log")}), said.append)
    shutil.rmtree(tmp_path / "log")
    (tmp_path / "log").touch()
    for _ in range(2):
        folder.keep_up()
        folder.log("INFO", "launch", "after")
    folder.close()
    assert len(said) == 1 and said[0].startswith("no log files from here on: Not a directory")


def test_a_rotation_finds_out_that_the_folder_is_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(
        RotatingFile.__init__, "__kwdefaults__", {"limit_bytes": 1000, "backups": 1}
    )
    said: list[str] = []
    folder = RunDirectory(new_run_path({"ROS_LOG_DIR": str(tmp_path / "log")}), said.append)
    folder.log("INFO", "launch", "x" * 500)
    shutil.rmtree(tmp_path / "log")
    folder.log("INFO", "launch", "y" * 500)
    folder.close()
    assert len(said) == 1 and "was removed" in said[0]
    assert "y" * 500 in (path_of(folder) / "launch.log").read_text()


def test_blocks_of_a_flood_are_merged_in_order_at_the_end_of_the_iteration(tmp_path: Path):
    calls: list[Callable[[], None]] = []
    path = new_run_path({"ROS_LOG_DIR": str(tmp_path)})
    folder = RunDirectory(path, pytest.fail, soon=calls.append)
    screen = OutputPolicy.named("screen")
    much, expected = "x" * FLOOD_BYTES, []
    for number in range(2 * MAX_TOGETHER):
        folder.write_lines("a-1", screen, "both", f"{number} {much}\n".encode())
        folder.write_lines("b-2", screen, "both", b"little\n")
        folder.log("INFO", "launch", "said")
        expected += [f"[a-1] {number} {much}", "[b-2] little", "[INFO] [launch]: said"]
    while calls:
        calls.pop(0)()
    lines = Path(path, "launch.log").read_text().splitlines()
    assert [line.partition(" ")[2] for line in lines] == expected
    folder.close()
