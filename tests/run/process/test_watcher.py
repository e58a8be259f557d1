"""The process that watches files: its death, its limits, and what it lacks."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys

import pytest

from tests.support.children import is_alive
from tests.support.controlled_run import TIMEOUT_S
from tests.support.waiting import wait_until
from tests.support.watching import Desk, pids, wait_for_watching, watchers


def test_a_watcher_that_is_killed_is_started_again(desk: Desk):
    with desk.run() as run:
        wait_for_watching(run, "a", "b")
        (watcher,) = watchers(run)
        watcher.kill()
        run.wait_for("the file watcher died (signal 9); restarting it")
        desk.part.write_text("VALUE = 10\n")  # also if nobody looks at this moment
        run.wait_for("a runs 10")
        run.wait_for("b runs 10")


def test_a_killed_launcher_leaves_nothing(desk: Desk):
    with desk.run() as run:
        wait_for_watching(run, "a", "b")
        (watcher,) = watchers(run)
        run.process.send_signal(signal.SIGKILL)
        run.process.wait()
        wait_until(lambda: not desk.bench.survivors(), "the end of everything")
        wait_until(lambda: not is_alive(watcher.pid), "the end of the watcher")


def test_a_folder_that_is_deleted_and_made_again(desk: Desk):
    with desk.run() as run:
        wait_for_watching(run, "a", "b")
        before = pids(run)
        kept = desk.bench.folder / "kept"
        shutil.copytree(desk.folder, kept)
        shutil.rmtree(desk.folder)
        run.wait_for("was deleted: a-1, b-2 run on with what they have loaded")
        assert pids(run) == before
        kept.rename(desk.folder)
        desk.part.write_text("VALUE = 11\n")
        run.wait_for("b runs 11")


@pytest.mark.thorough
def test_a_thousand_files(desk: Desk):
    names = [f"part_{number}" for number in range(1000)]
    for name in names:
        (desk.folder / f"{name}.py").write_text("VALUE = 0\n")
    imports = "".join(f"import {name}\n" for name in names)
    desk.part.write_text(f"{imports}VALUE = 1 + part_999.VALUE\n")
    with desk.run() as run:
        wait_for_watching(run, "a", "b")
        assert run.ask("info", "a")["processes"][0]["watched_files"] == 1002
        (desk.folder / "part_999.py").write_text("VALUE = 41\n")
        run.wait_for("a runs 42")
        run.wait_for("b runs 42")


def test_full_inotify_watches_are_named_with_their_repair(desk: Desk):
    def in_namespace(text: str) -> list[str]:
        limit = "/proc/sys/user/max_inotify_watches"
        return ["unshare", "-Ur", "sh", "-c", f"echo 0 > {limit} && {text}"]

    if subprocess.run(in_namespace("true"), capture_output=True, check=False).returncode != 0:
        pytest.skip("user namespaces are not allowed here")
    watcher = subprocess.Popen(
        in_namespace(f"exec {sys.executable} -m launcher.run.watch"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert watcher.stdin is not None and watcher.stdout is not None
    request = {
        "process": "a",
        "argv": [sys.executable, f"{desk.folder}/node.py"],
        "env": dict(os.environ),
        "cwd": None,
        "parameters": [],
        "members": [],
        "started_ns": 1 << 62,
    }
    with watcher:
        print(json.dumps(request), file=watcher.stdin, flush=True)
        found = [json.loads(watcher.stdout.readline()) for _ in range(2)]
        (warning,) = [one["warning"] for one in found if "warning" in one]
        assert "the limit of inotify watches is reached (fs.inotify.max_user_watches=" in warning
        assert "hint: sudo sysctl fs.inotify.max_user_watches=" in warning
        desk.part.write_text("VALUE = 12\n")  # files are looked at instead
        assert json.loads(watcher.stdout.readline())["changed"] == [str(desk.part)]
        watcher.stdin.close()
        assert watcher.wait(TIMEOUT_S) == 0


def test_without_watchfiles_the_error_has_the_command_that_installs_it(desk: Desk):
    blocked = (
        "import sys, importlib.util as u; find = u.find_spec; "
        "u.find_spec = lambda name, *a: None if name == 'watchfiles' else find(name, *a); "
        "from launcher.__main__ import main; sys.exit(main())"
    )
    words = desk.bench.command(desk.nodes, "--watch")[3:]
    done = subprocess.run(
        [sys.executable, "-c", blocked, *words],
        env=desk.bench.env,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert done.returncode == 2
    assert "watching files needs the Python package 'watchfiles'" in done.stderr
    assert "[watch]" in done.stderr
    assert "runs" not in done.stdout
