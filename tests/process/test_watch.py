"""Files that change while processes run that have loaded them, as editors and git do it."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest

from launcher.control.client import RefusedError
from tests.process.conftest import ControlBench
from tests.support.controlled_run import TIMEOUT_S, ControlledRun
from tests.support.waiting import wait_until

PROGRAM = """import signal
import sys
import time

import part

signal.signal(signal.SIGINT, lambda *args: sys.exit(0))
print(f"{sys.argv[1]} runs {part.VALUE}", flush=True)
time.sleep(1000)
"""


class Desk:
    """Nodes `a` and `b` that have loaded `part.py`, watched by a run."""

    def __init__(self, bench: ControlBench) -> None:
        self.bench = bench
        self.folder = bench.folder / "src"
        self.folder.mkdir()
        self.part = self.folder / "part.py"
        (self.folder / "node.py").write_text(PROGRAM)
        self.part.write_text("VALUE = 1\n")

    def node(self, name: str, more: str = "") -> str:
        words = f'sys.executable, "{self.folder}/node.py", "{name}"'
        return f'ExecuteProcess(cmd=[{words}], name="{name}", output="screen"{more})'

    @property
    def nodes(self) -> str:
        return f"{self.node('a')}, {self.node('b')}"

    def run(self, actions: str | None = None, *words: str) -> ControlledRun:
        return self.bench.launch(actions or self.nodes, "--watch", *words)

    @property
    def launch_file(self) -> Path:
        return self.bench.folder / "bench.launch.py"


@pytest.fixture
def desk(control_bench: ControlBench) -> Iterator[Desk]:
    yield Desk(control_bench)


def is_watched(run: ControlledRun, *names: str) -> bool:
    rows = {row["name"].rpartition("-")[0]: row for row in run.ask("watch")["processes"]}
    return all(rows[name]["files"] for name in names)


def wait_for_watching(run: ControlledRun, *names: str) -> None:
    for name in names:
        run.wait_for(f"{name} runs 1")
    wait_until(lambda: is_watched(run, *names), "the files of all nodes")


def pids(run: ControlledRun) -> dict[str, int | None]:
    return {row["name"]: row["pid"] for row in run.ask("ps")["processes"]}


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


@pytest.mark.parametrize("save", [in_place, as_vim, as_vs_code, in_pieces])
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


def test_a_parameter_file(desk: Desk):
    parameters = desk.folder / "p.yaml"
    parameters.write_text("/**: {ros__parameters: {x: 1}}\n")
    node = desk.node("a").replace(
        ', "a"]', f', "a", "--ros-args", "--params-file", "{parameters}"]'
    )
    with desk.run(node) as run:
        wait_for_watching(run, "a")
        before = pids(run)
        parameters.write_text("a: 1\n")
        run.wait_for("p.yaml:1: expected 'ros__parameters:' below 'a'")
        assert pids(run) == before
        parameters.write_text("/**: {ros__parameters: {x: 2}}\n")
        run.wait_for("p.yaml changed: a-1 restarts")
        wait_until(lambda: run.screen.count("a runs 1") == 2, "the restart")


def test_the_launch_file_and_what_it_includes(desk: Desk):
    included = desk.bench.folder / "other.launch.py"
    head = desk.launch_file
    text = """from launch import LaunchDescription
from launch.actions import ExecuteProcess
def generate_launch_description():
    return LaunchDescription([ExecuteProcess(cmd=["sleep", "{}"], name="included")])
"""
    included.write_text(text.format(1000))
    include = f"""__import__("launch").actions.IncludeLaunchDescription("{included}")"""
    with desk.run(f"{desk.node('a')}, {include}") as run:
        wait_for_watching(run, "a")
        wait_until(lambda: len(run.ask("watch")["launch_files"]) == 2, "the launch files")
        before = pids(run)
        included.write_text(text.format(2000))
        run.wait_for("the launch file was reloaded: changed: included-2")
        assert pids(run)["a-1"] == before["a-1"]
        head.write_text(head.read_text() + ")")
        run.wait_for("the launch file was not reloaded: everything runs on")
        assert "bench.launch.py:21: unmatched ')'" in run.screen or ": unmatched ')'" in run.screen
        desk.bench.command(f"{desk.node('a')}, {desk.node('b')}")
        run.wait_for("the launch file was reloaded: new: b-3; gone: included-2")
        assert pids(run)["a-1"] == before["a-1"]
        wait_for_watching(run, "a", "b")
        desk.part.write_text("VALUE = 9\n")
        run.wait_for("b runs 9")


def test_a_restart_that_the_end_of_the_run_prevents_is_told(desk: Desk):
    slow = """sh('trap "echo stopping" INT; echo {}; while :; do sleep 0.1; done', name="slow",
        output="screen", sigterm_timeout="1.0")"""
    with desk.run(slow.format("first")) as run:
        run.wait_for("first")
        wait_until(lambda: run.ask("watch")["launch_files"], "the launch file to be watched")
        desk.bench.command(slow.format("second"))
        run.wait_for("stopping")
        run.process.send_signal(signal.SIGINT)
        run.exit_code()
        assert "the launch file was reloaded: not restarted: slow-1" in run.screen


def test_a_file_that_the_launch_file_reads(desk: Desk):
    names = desk.bench.folder / "names.txt"
    names.write_text("one")
    actions = f"""*[sh("exec sleep 1000", name=name) for name in open("{names}").read().split()]"""
    with desk.run(actions) as run:
        wait_until(lambda: str(names) in run.ask("watch")["launch_files"], "the file that is read")
        before = pids(run)
        names.write_text("one two")
        run.wait_for("names.txt changed: the launch file is evaluated again")
        run.wait_for("the launch file was reloaded: new: two-2")
        assert before.items() <= pids(run).items()


LIFECYCLE_NODE = """import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import Node, TransitionCallbackReturn

import part

class Steered(Node):
    def on_configure(self, state):
        print(f"configured {part.VALUE}", flush=True)
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        print(f"activated {part.VALUE}", flush=True)
        return super().on_activate(state)

rclpy.init()
node = Steered("steered")
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""
LIFECYCLE_ACTIONS = """*__import__("steering").actions({!r})"""
STEERING = """from launch.actions import EmitEvent, RegisterEventHandler
from launch.events import matches_action
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState

def actions(script):
    node = LifecycleNode(executable=script, name="steered", namespace="", output="screen")
    def change(number):
        matcher = matches_action(node)
        return EmitEvent(event=ChangeState(lifecycle_node_matcher=matcher, transition_id=number))
    handler = OnStateTransition(
        target_lifecycle_node=node, goal_state="inactive", entities=[change(3)])
    return [node, RegisterEventHandler(handler), change(1)]
"""


@pytest.mark.thorough
def test_a_lifecycle_node_goes_through_its_transitions_again(desk: Desk):
    script = desk.folder / "steered.py"
    script.write_text(f"#!{sys.executable}\n{LIFECYCLE_NODE}")
    script.chmod(0o755)
    (desk.bench.folder / "steering.py").write_text(STEERING)
    path = f"*(sys.path.insert(0, {str(desk.bench.folder)!r}) or ()), "
    with desk.run(path + LIFECYCLE_ACTIONS.format(str(script))) as run:
        run.wait_for("activated 1")
        wait_until(lambda: run.ask("watch")["processes"][0]["files"], "the files")
        assert {one["change"] for one in run.ask("reload")["processes"]} == {"same"}
        desk.part.write_text("VALUE = 2\n")
        run.wait_for("activated 2")
        assert {one["change"] for one in run.ask("reload")["processes"]} == {"same"}
        desk.part.write_text("VALUE = 3\n")
        run.wait_for("activated 3")
        for value in (1, 2):
            assert run.screen.count(f"activated {value}") == 1, "it was asked for again"


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
        wait_until(lambda: not _watchers(run), "the end of the watcher")
        with pytest.raises(RefusedError, match="unknown process 'nobody'"):
            run.ask("watch", "nobody", state="on")


def _watchers(run: ControlledRun) -> list[psutil.Process]:
    children = psutil.Process(run.process.pid).children()
    return [one for one in children if "launcher.watch" in one.cmdline()]


def test_a_watcher_that_is_killed_is_started_again(desk: Desk):
    with desk.run() as run:
        wait_for_watching(run, "a", "b")
        (watcher,) = _watchers(run)
        watcher.kill()
        run.wait_for("the file watcher died (signal 9); restarting it")
        desk.part.write_text("VALUE = 10\n")  # also if nobody looks at this moment
        run.wait_for("a runs 10")
        run.wait_for("b runs 10")


def test_a_killed_launcher_leaves_nothing(desk: Desk):
    with desk.run() as run:
        wait_for_watching(run, "a", "b")
        (watcher,) = _watchers(run)
        run.process.send_signal(signal.SIGKILL)
        run.process.wait()
        wait_until(lambda: not desk.bench.survivors(), "the end of everything")
        wait_until(
            lambda: not watcher.is_running() or watcher.status() == psutil.STATUS_ZOMBIE,
            "the end of the watcher",
        )


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
        in_namespace(f"exec {sys.executable} -m launcher.watch"),
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
    assert "pip install -e '.[watch]'" in done.stderr
    assert "runs" not in done.stdout


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
