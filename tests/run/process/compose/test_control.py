"""A process of several nodes under the verbs and options of a run."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from launcher.posix.socket_directory import ControlError
from tests.run.process.compose.composed import PROGRAM, end, pid_of, plain, script
from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun
from tests.support.waiting import wait_until

pytest.importorskip("rclpy")

CHILD = """
import os, subprocess, sys
print("children have", subprocess.getoutput("ls -l /proc/self/fd | grep -c socket:"), flush=True)
print("and read", repr(subprocess.run(["cat"], capture_output=True, timeout=60).stdout), flush=True)
print("it reads", repr(sys.stdin.read()), flush=True)
"""


def test_nobody_but_the_process_itself_gets_the_connection_to_the_launcher(
    bench: ControlBench, tmp_path: Path
):
    action = script(tmp_path / "child.py", CHILD)
    with bench.launch(f"{action}, {plain('careful')}", "--compose", "*") as run:
        run.wait_for("[INFO] [child-1]: node has finished cleanly in composed-1")
        run.wait_for("[careful-2] [INFO]")
        with pytest.raises(ControlError, match="composed-1 is composed, and has no standard input"):
            run.ask("send", "composed-1", text="1 15")
        assert run.row("composed-1")["state"] == "RUNNING"
        end(run)
    for text in ("children have 0", "and read b''", "it reads ''"):
        assert f"[child-1] {text}\n" in run.screen


@pytest.mark.thorough
def test_verbs_are_about_the_group(bench: ControlBench):
    actions = f"{plain('careful', more=', name=' + repr('careful'))}, {plain('usual')}"
    with bench.launch(actions, "--compose", "*") as run:
        run.wait_for("[usual-2] [INFO]")
        assert run.row("composed-1")["node_names"] == ["/careful"]
        with pytest.raises(ControlError, match="composed-1 is the process of 2 nodes: careful-1"):
            run.ask("stop", "careful")
        with pytest.raises(ControlError, match="is the process of 2 nodes: careful-1"):
            run.ask("debug", "careful")
        refusal = run.shell("loglevel", "careful", "debug").stderr
        assert "careful does not offer" in refusal
        assert "--log-level careful=debug" in refusal
        before = pid_of(run)
        run.ask("restart", "composed-1")
        assert pid_of(run) != before
        started = f"process started with pid [{pid_of(run)}]"
        wait_until(lambda: "[usual-2] [INFO]" in run.screen.partition(started)[2], "its lines")
        lines = [line["text"] for line in run.ask("logs", "composed-1")["lines"]]
        assert "[careful-1] careful was stopped" in lines
        folder = Path(run.connect().hello["run"]["log_dir"])
        with pytest.raises(ControlError, match="a run with composed nodes cannot be reloaded"):
            run.ask("reload")
        end(run)
    assert "[careful-1] careful was stopped" in (folder / "launch.log").read_text()


@pytest.mark.parametrize("verb", ["stop", pytest.param("kill", marks=pytest.mark.thorough)])
def test_a_group_that_a_user_stops_is_held_and_may_be_started_again(bench: ControlBench, verb: str):
    actions = f"{plain('careful')}, {plain('careful', name='other')}"
    with bench.launch(actions, "--compose", "*") as run:
        wait_until_both_log(run)
        options = {"signal": int(signal.SIGINT)} if verb == "kill" else {}
        run.ask(verb, "composed-1", **options)
        assert run.row("composed-1")["state"] == "STOPPED"
        run.ask("start", "composed-1")
        wait_until_both_log(run)
        before = pid_of(run)
        run.ask("restart", "composed-1")
        wait_until_both_log(run)
        assert pid_of(run) != before
        end(run)
    assert run.screen.count("\n[careful-1] careful was stopped") == 3
    assert run.screen.count("\n[other-2] other was stopped") == 3


def wait_until_both_log(run: ControlledRun) -> None:
    """In the life of their process that runs now."""
    started = f"process started with pid [{pid_of(run)}]"
    for name in ("careful-1", "other-2"):
        text = f"[{name}] [INFO]"
        wait_until(lambda text=text: text in run.screen.partition(started)[2], text)


@pytest.mark.thorough
def test_an_edit_of_one_program_restarts_the_group(bench: ControlBench):
    program = bench.folder / "edited.py"
    text = PROGRAM.read_text()
    program.write_text(text)
    on_exit = ", on_exit=__import__('launch').actions.Shutdown()"
    edited = plain("careful", more=on_exit).replace(str(PROGRAM), str(program))
    with bench.launch(f"{edited}, {plain('usual')}", "--compose", "*", "--watch") as run:
        run.wait_for("[careful-1] [INFO]")
        run.wait_for("[usual-2] [INFO]")
        before = pid_of(run)
        wait_until(lambda: "edited.py" in str(run.ask("watch")), "it is watched")
        program.write_text(text.replace("was stopped", "was ended"))
        run.wait_for("[careful-1] careful was stopped")
        wait_until(lambda: pid_of(run) not in (None, before), "the new process")
        started = f"process started with pid [{pid_of(run)}]"
        wait_until(lambda: "[careful-1] [INFO]" in run.screen.partition(started)[2], "its lines")
        run.ask("quit")
        assert run.exit_code() == 0, run.screen
    assert "[careful-1] careful was ended" in run.screen


def test_what_is_started_later_and_what_is_not_there_is_told(bench: ControlBench):
    late = f"TimerAction(period=0.5, actions=[{plain('words', name='late')}])"
    actions = f"{plain('words')}, {plain('words', name='more')}, {late}, sh('true', name='tool')"
    with bench.launch(actions, "--compose", "[wmlt]*", "--compose", "robto_*") as run:
        assert run.exit_code() == 0, run.screen
    assert "composed-1 is one process for 2 nodes: words-1, more-2" in run.screen
    assert "late-4 is not composed: it is not started at the beginning of the run" in run.screen
    assert "tool-3 is not composed: it is not started as a ROS node" in run.screen
    assert "--compose 'robto_*' matches no process of the whole run" in run.screen


def test_a_plan_tells_of_the_groups(bench: ControlBench):
    late = f"TimerAction(period=0.5, actions=[{plain('words', name='late')}])"
    words = ["--compose", "*", "-p"]
    done = bench.run(f"{plain('words')}, {plain('words', name='more')}, {late}", *words)
    out = done.stdout.decode()
    assert done.returncode == 0, done.stderr
    assert "note: composed-1 is one process for 2 nodes: words-1, more-2" in out
    assert "note: late-3 is not composed: it is not started at the beginning of the run" in out
