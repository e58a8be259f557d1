"""Warm starts in a real run: which nodes, edited code, and the end of the launcher."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import psutil
import pytest

from tests.support.benches import ControlBench
from tests.support.children import children_with
from tests.support.controlled_run import ControlledRun
from tests.support.repository import REPOSITORY
from tests.support.supervising import events
from tests.support.waiting import wait_until

SCRIPT = """#!{python}
import value
print("value is", value.VALUE, flush=True)
import signal
signal.pause()
"""


def node_script(folder: Path, text: str = SCRIPT) -> Path:
    script = folder / "node"
    script.write_text(text.format(python=sys.executable))
    script.chmod(0o755)
    (folder / "value.py").write_text("VALUE = 1\n")
    return script


def nodes(script: Path, count: int) -> str:
    """Actions that start so many nodes of this script; `Bench` has no import of Node."""
    one = '__import__("launch_ros.actions").actions.Node(executable="{}", output="screen"),'
    return count * one.format(script)


def preparing_of(run: ControlledRun) -> list[psutil.Process]:
    return children_with(run.process.pid, "warm/preparing")


# Python runs it in each interpreter: that which prepares goes on when the file is removed.
HOLD = """import os, sys, time
if any("warm/preparing" in word for word in sys.orig_argv):
    while os.path.exists({file!r}):
        time.sleep(0.02)
"""


@pytest.fixture
def hold(control_bench: ControlBench) -> Path:
    """As long as this file is there, the preparing process is not done."""
    file = control_bench.folder / "hold"
    file.touch()
    site = control_bench.folder / "site"
    site.mkdir()
    (site / "sitecustomize.py").write_text(HOLD.format(file=str(file)))
    paths = [str(site), *filter(None, [control_bench.env.get("PYTHONPATH")])]
    control_bench.env["PYTHONPATH"] = os.pathsep.join(paths)
    return file


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "programs"
    folder.mkdir()
    return folder


def test_many_nodes_wait_for_the_preparation_and_are_warm(control_bench: ControlBench, folder):
    script = node_script(folder)
    count = len(os.sched_getaffinity(0)) + 1
    with control_bench.launch(nodes(script, count)) as run:
        wait_until(lambda: run.screen.count("value is 1") == count, "all print")
        rows = run.ask("ps")["processes"]
        assert [row["start"] for row in rows] == ["warm"] * count
        assert run.ask("info", "node-1")["processes"][0]["start_text"] == "warm"
        assert "  started    warm\n" in run.ask_text("info", "node-1")
        assert run.ask_text("ps").count("  warm") == count
        for row in rows:
            assert psutil.Process(row["pid"]).cmdline()[1] == str(script)
            assert psutil.Process(row["pid"]).ppid() == run.process.pid
        run.process.send_signal(signal.SIGINT)
        run.exit_code()
        assert "leftover" not in run.screen


def test_one_node_is_cold_and_its_restart_prepared(control_bench: ControlBench, folder):
    script = node_script(folder)
    with control_bench.launch(nodes(script, 1)) as run:
        run.wait_for("value is 1")
        row = run.ask("info", "node-1")["processes"][0]
        assert row["start_text"] == "cold, because it would have waited for the preparation"
        assert not preparing_of(run)
        run.ask("restart", "node-1")
        wait_until(lambda: preparing_of(run), "its next start is prepared")
        wait_until(lambda: run.screen.count("value is 1") == 2, "it runs again")
        assert run.row("node-1")["start"] == "cold"

        def restarts_warm() -> bool:
            run.ask("restart", "node-1")
            return bool(run.row("node-1")["start"] == "warm")

        wait_until(restarts_warm, "it is prepared")


def test_with_watch_the_restart_of_one_node_is_prepared(control_bench: ControlBench, folder):
    script = node_script(folder)
    with control_bench.launch(nodes(script, 1), "--watch") as run:
        run.wait_for("value is 1")
        wait_until(lambda: preparing_of(run), "its next start is prepared")


def test_cold_and_other_programs_prepare_nothing(control_bench: ControlBench, folder):
    script = node_script(folder)
    with control_bench.launch(nodes(script, 4), "--cold") as run:
        wait_until(lambda: run.screen.count("value is 1") == 4, "all print")
        assert not preparing_of(run)
        assert {row["start"] for row in run.ask("ps")["processes"]} == {"cold"}
        assert run.ask("info", "node-1")["processes"][0]["start_text"] == "cold"
    python = f'ExecuteProcess(cmd=["{script}"], output="screen"),'
    with control_bench.launch(4 * python) as run:
        wait_until(lambda: run.screen.count("value is 1") == 4, "all print")
        assert not preparing_of(run)


def test_a_reload_during_the_preparation_starts_what_the_new_file_says(
    control_bench: ControlBench, folder, hold: Path
):
    text = "#!{python}\nimport sys, signal\nprint(open(sys.argv[-1]).read(), flush=True)\n"
    script = node_script(folder, text + "signal.pause()\n")
    others = nodes(script, 2).replace("output=", 'arguments=["/dev/null"], output=')
    first = nodes(script, 1).replace("output=", 'parameters=[{{"x": {}}}], output=')
    with control_bench.launch(first.format(1111) + others, "--warm") as run:
        wait_until(lambda: preparing_of(run), "it prepares")
        control_bench.command(first.format(2222) + others)
        changes = {one["name"]: one["change"] for one in run.ask("reload")["processes"]}
        assert changes["node-1"] == "changed"
        hold.unlink()
        run.wait_for("x: 2222")
        assert "x: 1111" not in run.screen
        assert {row["start"] for row in run.ask("ps")["processes"]} == {"warm"}


def started_s(bench: ControlBench, name: str) -> float | None:
    """When the process was started, on the monotonic clock."""
    found = [
        event["monotonic_s"]
        for event in events(bench)
        if event["event"] == "started" and event["process"] == name
    ]
    return found[0] if found else None


def held(script: Path, more: str = "") -> str:
    """Nodes that wait, a timer of 1 s of their moment, and a clock that shows when 1.5 s passed."""
    late = 'TimerAction(period=1.0, actions=[sh("exec sleep 1000", name="late")]),'
    clock = 'sh("sleep 1.5", name="clock"),'
    return nodes(script, len(os.sched_getaffinity(0)) + 1) + late + clock + more


def prepares(run: ControlledRun) -> psutil.Process:
    """The preparing process, which is held, when 1.5 s have passed."""
    wait_until(lambda: preparing_of(run), "it prepares")
    (preparing,) = preparing_of(run)
    clock = f"[clock-{len(os.sched_getaffinity(0)) + 2}]: process has finished cleanly"
    run.wait_for(clock)
    return preparing


def late_name() -> str:
    return f"late-{len(os.sched_getaffinity(0)) + 3}"


def test_timers_count_from_the_warm_starts_of_their_moment(
    control_bench: ControlBench, folder, hold: Path
):
    with control_bench.launch(held(node_script(folder))) as run:
        prepares(run)
        assert started_s(control_bench, late_name()) is None
        assert started_s(control_bench, "node-1") is None
        hold.unlink()
        wait_until(lambda: started_s(control_bench, late_name()), "the timer fires")
        assert {run.row("node-1")["start"], run.row("late")["start"]} == {"warm", "cold"}
        begun_s, late_s = started_s(control_bench, "node-1"), started_s(control_bench, late_name())
        assert begun_s is not None and late_s is not None
        assert late_s - begun_s >= 1.0


@pytest.mark.thorough
@pytest.mark.usefixtures("hold")
def test_if_the_preparation_fails_they_count_from_the_cold_starts(
    control_bench: ControlBench, folder
):
    with control_bench.launch(held(node_script(folder))) as run:
        prepares(run).kill()
        wait_until(lambda: started_s(control_bench, late_name()), "the timer fires")
        assert run.row("node-1")["start"] == "cold"
        begun_s, late_s = started_s(control_bench, "node-1"), started_s(control_bench, late_name())
        assert begun_s is not None and late_s is not None
        assert late_s - begun_s >= 1.0


@pytest.mark.thorough
@pytest.mark.usefixtures("hold")
def test_if_the_starts_are_given_up_the_timers_count(control_bench: ControlBench, folder):
    with control_bench.launch(held(node_script(folder))) as run:
        prepares(run)
        run.ask("stop", "node-*")
        wait_until(lambda: started_s(control_bench, late_name()), "the timer fires")
        given_up_s = [
            event["monotonic_s"] for event in events(control_bench) if event["event"] == "withdrawn"
        ]
        late_s = started_s(control_bench, late_name())
        assert late_s is not None and late_s - max(given_up_s) >= 1.0


@pytest.mark.usefixtures("hold")
def test_a_stop_while_timers_wait_ends_the_run(control_bench: ControlBench, folder):
    lasting = """TimerAction(period=0.5, cancel_on_shutdown=False, actions=[
        LogInfo(msg="outlived the stop")]),"""
    with control_bench.launch(held(node_script(folder), lasting)) as run:
        prepares(run)
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0
        assert run.screen.count("outlived the stop") == 1
        assert started_s(control_bench, late_name()) is None


@pytest.mark.thorough
def test_a_reload_while_timers_wait_does_not_shorten_them(
    control_bench: ControlBench, folder, hold: Path
):
    script = node_script(folder)
    with control_bench.launch(held(script)) as run:
        prepares(run)
        control_bench.command(held(script, 'sh("exec sleep 1000", name="added"),'))
        run.ask("reload")
        run.wait_for("[added-")
        assert "late-" not in run.screen
        hold.unlink()
        run.wait_for("[late-")
        (late,) = [row["name"] for row in run.ask("ps", "late")["processes"]]
        wait_until(lambda: started_s(control_bench, late), "it is noted")
        begun_s, late_s = started_s(control_bench, "node-1"), started_s(control_bench, late)
        assert begun_s is not None and late_s is not None
        assert late_s - begun_s >= 1.0


def test_starts_that_wait_for_the_preparation_stay_a_stagger_apart(
    control_bench: ControlBench, folder, hold: Path
):
    clock = 'sh("sleep 1", name="clock"),'  # when it has ended, all of them would have been due
    with control_bench.launch(
        clock + nodes(node_script(folder), 3), "--warm", "--stagger", "0.2"
    ) as run:
        wait_until(lambda: preparing_of(run), "it prepares")
        run.wait_for("[clock-1]: process has finished cleanly")
        hold.unlink()
        wait_until(lambda: started_s(control_bench, "node-4"), "the last start")
        times = [started_s(control_bench, f"node-{number}") or 0.0 for number in (2, 3, 4)]
        assert all(after - before >= 0.2 for before, after in pairwise(times))


def test_edited_code_is_used_by_the_next_start(control_bench: ControlBench, folder):
    script = node_script(folder)
    with control_bench.launch(nodes(script, 1), "--warm") as run:
        run.wait_for("value is 1")
        for value in (22, 333, 4444):  # within a second, and of different length
            (folder / "value.py").write_text(f"VALUE = {value}\n")
            run.ask("restart", "node-1")
            run.wait_for(f"value is {value}")
            assert run.row("node-1")["start"] == "warm"
        (folder / "value.py").write_text("VALUE = (\n")
        run.ask("restart", "node-1")
        run.wait_for("SyntaxError")


def test_a_killed_launcher_leaves_nothing(control_bench: ControlBench, folder):
    script = node_script(folder)
    run = control_bench.launch(nodes(script, 3), "--warm")
    with run:
        wait_until(lambda: run.screen.count("value is 1") == 3, "all print")
        assert len(preparing_of(run)) == 1
        run.process.kill()
        run.exit_code()
        wait_until(lambda: not control_bench.survivors(), "all have ended")


def test_a_launcher_killed_during_the_preparation_leaves_nothing(
    control_bench: ControlBench, folder
):
    script = node_script(folder, "#!{python}\nimport numpy, rclpy\n")
    run = control_bench.launch(nodes(script, 3), "--warm")
    with run:
        wait_until(lambda: preparing_of(run), "it prepares")
        run.process.kill()
        run.exit_code()
        wait_until(lambda: not control_bench.survivors(), "all have ended")


@pytest.mark.usefixtures("hold")
def test_ctrl_c_during_the_preparation_ends_the_run_in_order(control_bench: ControlBench, folder):
    script = node_script(folder, "#!{python}\nimport numpy, rclpy\nprint('began')")
    with control_bench.launch(nodes(script, 3), "--warm") as run:
        wait_until(lambda: preparing_of(run), "it prepares")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 130
        assert "exit code 130: nothing was started; ended by: ctrl-c (SIGINT)" in run.screen
        assert "began" not in run.screen
        assert not control_bench.survivors()


def test_nodes_go_on_without_the_process_that_has_made_them(control_bench: ControlBench, folder):
    script = node_script(folder)
    with control_bench.launch(nodes(script, 2), "--warm") as run:
        wait_until(lambda: run.screen.count("value is 1") == 2, "both print")
        preparing_of(run)[0].kill()
        run.wait_for("the preparing process failed, nodes are started cold: it was ended by")
        assert {row["state"] for row in run.ask("ps")["processes"]} == {"RUNNING"}
        run.ask("stop", "node-1")
        assert run.row("node-1")["last_exit"]["returncode"] == -signal.SIGINT


# ---- packages with effects at their import, in an environment of their own

STARTS_A_THREAD = """import threading
threading.Thread(target=threading.Event().wait, daemon=True).start()"""
EFFECTS = {
    "plain": "VALUE = 1",
    "starts_threads": STARTS_A_THREAD,
    "writes": "print('hello from an import')",
    "opens_a_file": "import tempfile\nfile = tempfile.TemporaryFile()",
    "sets_a_variable": "import os\nos.environ['SET_AT_IMPORT'] = '1'",
    "handles_a_signal": "import signal\nsignal.signal(signal.SIGUSR1, lambda *a: None)",
    "fails": "raise RuntimeError('no import of this')",
    "exits": "raise SystemExit('no way')",
    "is_lazy": "import importlib.util, sys\n"
    "spec = importlib.util.find_spec('late')\n"
    "spec.loader = importlib.util.LazyLoader(spec.loader)\n"
    "sys.modules['late'] = late = importlib.util.module_from_spec(spec)\n"
    "spec.loader.exec_module(late)",
    "late": STARTS_A_THREAD,
}
USER = """
import os, signal, sys, threading
import plain, starts_threads, writes, opens_a_file, sets_a_variable, handles_a_signal, is_lazy
is_lazy.late.threading  # which loads it
try:
    import fails
except RuntimeError:
    pass
print("plain", plain.VALUE, "threads", threading.active_count(),
      "variable", os.environ.get("SET_AT_IMPORT"), "file", opens_a_file.file.fileno() > 2,
      "handler", callable(signal.getsignal(signal.SIGUSR1)), flush=True)
signal.pause()
"""


@pytest.fixture
def environment(tmp_path: Path) -> Path:
    """An environment with these packages; its interpreter."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "env"], check=True)
    (packages,) = (tmp_path / "env").glob("lib/python*/site-packages")
    for name, text in EFFECTS.items():
        (packages / f"{name}.py").write_text(text + "\n")
    return tmp_path / "env/bin/python"


def test_packages_with_effects_are_imported_by_the_program_itself(
    control_bench: ControlBench, environment: Path, folder: Path
):
    (folder / "user.py").write_text(USER)
    (folder / "token.py").touch()  # as a module of the standard library that is not needed
    action = f'ExecuteProcess(cmd=["{environment}", "{folder}/user.py"], output="screen"),'
    command = [str(environment), *control_bench.command(2 * action, "--warm")[1:]]
    control_bench.env["PYTHONPATH"] = str(REPOSITORY)
    run = ControlledRun(
        command,
        env=control_bench.env,
        runtime=control_bench.runtime,
        screen=folder / "screen",
    )
    expected = "plain 1 threads 3 variable 1 file True handler True"
    with run:
        wait_until(lambda: run.screen.count(expected) == 2, f"both print; {run.screen}")
        assert run.screen.count("hello from an import") == 2
        assert {row["start"] for row in run.ask("ps")["processes"]} == {"warm"}
        # A package that has changed is imported again.
        (plain,) = environment.parents[1].glob("lib/python*/site-packages/plain.py")
        plain.write_text("VALUE = 2222\n")
        before = preparing_of(run)[0].pid
        run.ask("restart", "python-1")
        run.wait_for("plain 2222")
        row = run.ask("info", "python-1")["processes"][0]
        assert row["start_text"] == f"cold, because '{plain}' has changed since it was prepared"

        def is_prepared_again() -> bool:
            run.ask("restart", "python-1")
            return bool(run.row("python-1")["start"] == "warm")

        wait_until(is_prepared_again, "a new preparing process")
        assert preparing_of(run)[0].pid != before
        run.process.send_signal(signal.SIGINT)
        run.exit_code()


def kinds(run: ControlledRun) -> list[str]:
    """How each was started, in the order of the starts."""
    return [row["start"] for row in run.ask("ps")["processes"]]


def test_what_is_held_back_is_prepared_for_meanwhile(control_bench: ControlBench, folder):
    count = len(os.sched_getaffinity(0)) + 1
    with control_bench.launch(nodes(node_script(folder), count), "--max-starting", "1") as run:
        wait_until(lambda: run.screen.count("value is 1") == count, "all print")
        assert kinds(run) == ["cold", *["warm"] * (count - 1)]


def test_after_many_late_starts_the_next_ones_are_prepared(control_bench: ControlBench, folder):
    count = 2 * len(os.sched_getaffinity(0)) + 2
    late = "*[TimerAction(period=0.01, actions=[one]) for one in [{}]]"
    with control_bench.launch(late.format(nodes(node_script(folder), count))) as run:
        wait_until(lambda: run.screen.count("value is 1") == count, "all print")
        assert kinds(run) == [*["cold"] * (count - 1), "warm"]


def test_what_is_no_node_is_cold_beside_warm_nodes(control_bench: ControlBench, folder):
    script = node_script(folder)
    count = len(os.sched_getaffinity(0)) + 1
    plain = f'ExecuteProcess(cmd=[sys.executable, "{script}"], output="screen")'
    with control_bench.launch(f"{nodes(script, count)} {plain}") as run:
        wait_until(lambda: run.screen.count("value is 1") == count + 1, "all print")
        assert kinds(run).count("warm") == count
