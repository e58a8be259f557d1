"""Files that change while processes run that have loaded them, as editors and git do it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.control.client import RefusedError
from tests.support.controlled_run import ControlledRun
from tests.support.variations import few_of
from tests.support.waiting import wait_until
from tests.support.watching import PROGRAM, Desk, is_watched, pids, wait_for_watching, watchers


def in_place(path: Path, text: str) -> None:
    path.write_text(text)  # opened with O_TRUNC


def as_vim(path: Path, text: str) -> None:
    """`:set backup`: the file is renamed, a new one written, the backup deleted."""
    backup = path.with_name(f"{path.name}~")
    (path.parent / "4913").write_text("")
    (path.parent / "4913").unlink()
    (path.parent / f".{path.name}.swp").write_text("swap")
    path.rename(backup)
    with open(path, "w") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    backup.unlink()


def as_vs_code(path: Path, text: str) -> None:
    """`files.atomicWrite` and many others: a new file takes the place of the old one."""
    new = path.with_name(f"{path.name}.tmp-1")
    new.write_text(text)
    new.replace(path)


def in_pieces(path: Path, text: str) -> None:
    """Empty at first, then half of it, which does not compile."""
    with open(path, "w") as file:
        file.flush()
        file.write(text[: len(text) // 2] + "(")
        file.flush()
        file.seek(0)
        file.write(text)
        file.truncate()


@pytest.mark.parametrize(
    "save", few_of([in_place, as_vim, as_vs_code, in_pieces], [in_place, as_vim])
)
def test_a_saved_file_restarts_each_node_that_has_loaded_it_once(
    desk: Desk, save: Callable[[Path, str], None]
):
    with desk.run(f"{desk.nodes}, sh('exec sleep 1000', name='other')") as run:
        wait_for_watching(run, "a", "b")
        before = pids(run)
        save(desk.part, "VALUE = 22\n")
        for name in ("a", "b"):
            run.wait_for(f"{name} runs 22")
        assert pids(run)["other-3"] == before["other-3"]
        assert run.screen.count("part.py changed: a-1, b-2 restart") == 1
        assert run.screen.count("runs 22") == 2
        run.ask_text("quit")
        assert run.exit_code() == 0


def test_an_error_of_syntax_is_shown_and_everything_runs_on(desk: Desk):
    with desk.run() as run:
        wait_for_watching(run, "a", "b")
        before = pids(run)
        desk.part.write_text("VALUE = (\n")
        run.wait_for("run on with what they have loaded")
        assert f"{desk.part}:1: '(' was never closed\n    VALUE = (\n            ^\n" in run.screen
        assert pids(run) == before
        desk.part.write_text("VALUE = 3\n")
        run.wait_for("b runs 3")
        assert run.screen.count("never closed") == 1


def test_a_checkout_of_fifty_files_is_one_restart(desk: Desk):
    names = [f"part_{number}" for number in range(50)]

    def write(value: int) -> None:
        for name in names:
            (desk.folder / f"{name}.py").write_text(f"VALUE = {value}\n")
        imports = "".join(f"import {name}\n" for name in names)
        total = " + ".join(f"{name}.VALUE" for name in names)
        desk.part.write_text(f"{imports}VALUE = {total}\n")

    def git(*words: str) -> None:
        settings = ("-c", "user.name=a", "-c", "user.email=a@b.c")
        subprocess.run(["git", *settings, *words], cwd=desk.folder, check=True, capture_output=True)

    desk.part.write_text("VALUE = 1\n")
    git("init", "-q")
    git("add", ".")
    git("commit", "-qm", "one")
    git("checkout", "-qb", "two")
    write(2)
    git("add", ".")
    git("commit", "-qm", "two")
    git("checkout", "-q", "-")
    with desk.run() as run:
        wait_for_watching(run, "a", "b")
        git("checkout", "-q", "two")
        run.wait_for("a runs 100")
        run.wait_for("b runs 100")
        wait_until(
            lambda: all(len(r["files"] or ()) == 52 for r in run.ask("watch")["processes"]),
            "the files of the new branch",
        )
        git("checkout", "-q", "-")
        wait_until(lambda: run.screen.count("b runs 1\n") == 2, "the old branch again")
        assert run.screen.count("a-1, b-2 restart") == 2


def test_a_user_stop_is_respected_and_a_crash_is_not(desk: Desk):
    with desk.run() as run:
        wait_for_watching(run, "a", "b")
        run.ask("stop", "b")
        desk.part.write_text("VALUE = 1 / 0\n")
        run.wait_for("part.py changed: a-1 restarts")
        run.wait_for("ZeroDivisionError")
        run.wait_for("no process runs; waiting for changes of files")
        assert run.row("a")["state"] == "EXITED"
        desk.part.write_text("VALUE = 4\n")
        run.wait_for("a runs 4")
        assert run.row("b")["state"] == "STOPPED"
        run.ask("start", "b")
        run.wait_for("b runs 4")


def test_a_node_that_waits_for_its_restart_is_started_at_once(desk: Desk):
    action = desk.node("a", ", respawn=True, respawn_delay=1000.0")
    with desk.run(action) as run:
        wait_for_watching(run, "a")
        run.ask("kill", "a", signal=9, as_crash=True)
        assert run.row("a")["state"] == "BACKOFF"
        desk.part.write_text("VALUE = 5\n")
        run.wait_for("a runs 5")
        assert run.row("a")["state"] == "RUNNING"


@pytest.mark.thorough
def test_a_change_during_the_restart_is_not_lost(desk: Desk):
    slow = PROGRAM.replace("sys.exit(0)", "(time.sleep(1.0), sys.exit(0))")
    (desk.folder / "node.py").write_text(slow)
    with desk.run(desk.node("a")) as run:
        wait_for_watching(run, "a")
        desk.part.write_text("VALUE = 6\n")
        run.wait_for("sending signal 'SIGINT'")
        desk.part.write_text("VALUE = 7\n")
        run.wait_for("a runs 7")


def test_a_stop_of_the_run_while_a_change_is_pending(desk: Desk):
    with desk.run() as run:
        wait_for_watching(run, "a", "b")
        desk.part.write_text("VALUE = 8\n")
        run.ask_text("quit")
        assert run.exit_code() == 0
    assert desk.bench.survivors() == []


def test_on_and_off_for_some_and_for_all(desk: Desk):
    with desk.bench.launch(desk.nodes) as run:
        run.wait_for("b runs 1")
        assert run.ask_text("watch") == "files are not watched; `watch on` begins"
        assert run.ask("watch", "a", state="on")["on"]
        wait_until(lambda: is_watched(run, "a"), "the files of a")
        assert run.ask("info", "a")["processes"][0]["watched_files"] == 2
        desk.part.write_text("VALUE = 2\n")
        run.wait_for("part.py changed: a-1 restarts")
        run.wait_for("a runs 2")
        assert "b runs 2" not in run.screen
        run.ask("watch", state="on")
        run.wait_for("b runs 2")  # it has loaded what is not there any more
        assert f"  {desk.part}" in run.ask_text("watch", "b").split("\n")
        assert not run.ask("watch", state="off")["on"]
        wait_until(lambda: not watchers(run), "the end of the watcher")
        with pytest.raises(RefusedError, match="unknown process 'nobody'"):
            run.ask("watch", "nobody", state="on")


def test_a_script_is_watched_and_cannot_be_reloaded(desk: Desk):
    script = desk.bench.folder / "script.py"
    script.write_text(
        f"""import sys
from launch import LaunchDescription, LaunchService
from launch.actions import ExecuteProcess
service = LaunchService()
service.include_launch_description(LaunchDescription([{desk.node("a")}]))
sys.exit(service.run())
"""
    )
    bench = desk.bench
    run = ControlledRun(
        [sys.executable, "-m", "launcher", str(script), "--watch"],
        env=bench.env,
        runtime=bench.runtime,
        screen=bench.folder / "screen-script",
    )
    with run:
        wait_for_watching(run, "a")
        with pytest.raises(RefusedError, match="a script with a LaunchService cannot be reloaded"):
            run.ask("reload")
        desk.part.write_text("VALUE = 13\n")
        run.wait_for("a runs 13")
