"""`--prefix`: words in front of commands, as they are run and as they are planned."""

from __future__ import annotations

import os
import shutil

import pytest

from tests.support.benches import ControlBench, Workspace
from tests.support.waiting import wait_until

NICE = os.nice(0) + 3


def test_the_words_are_in_front_of_the_commands_that_match(control_bench: ControlBench):
    actions = """sh("nice; exec sleep 1000", name="arm_1"), sh("nice; exec sleep 1000", name="leg"),
        ExecuteProcess(cmd=["nice;", "exec sleep 1000"], shell=True, name="arm_2", output="screen"),
    """
    prefix = "arm_*=env 'A=b  c' nice -n 3"
    with control_bench.launch(actions, "--prefix", prefix, "--prefix", "none=nice") as run:
        for name, nice in (("arm_1-1", NICE), ("leg-2", os.nice(0)), ("arm_2-3", NICE)):
            run.wait_for(f"[{name}] {nice}\n")
        command = ["env", "A=b  c", "nice", "-n", "3", "sh", "-c", "nice; exec sleep 1000"]
        (info,) = run.ask("info", "arm_1")["processes"]
        assert info["cmd"] == command
        assert run.ask("plan")["processes"][0]["cmd"] == command
        run.wait_for("--prefix 'none' matches no process so far")


def test_a_plan_has_the_words_too(workspace: Workspace):
    file = workspace.write('ExecuteProcess(cmd=["true"], name="arm"),')
    touch, arm = workspace.document(file, "--prefix", "a*=nice -n 3")["processes"]
    assert touch["cmd"] == ["touch", str(workspace.started)]
    assert arm["cmd"] == ["nice", "-n", "3", "true"]
    shown = workspace.call(file, "-p", "--prefix=arm=nice -n '3'", "--prefix", "amr=nice")
    assert "$ nice -n 3 true" in shown.stdout
    assert "--prefix 'amr' matches no process (did you mean 'arm'?)" in shown.stdout
    assert not workspace.started.exists()


@pytest.mark.parametrize(
    ("word", "problem"),
    [
        ("arm", "in 'arm': expected NAME=..."),
        ("arm=", "in 'arm=': expected NAME=..."),
        ("arm='", "no closing quotation"),
        ("arm=''", "there are no words"),
        ("arm=no-such-tracer -f", "there is no program 'no-such-tracer'"),
    ],
)
def test_mistakes_are_refused_before_anything_starts(workspace: Workspace, word, problem):
    done = workspace.call(workspace.write(""), "--prefix", word)
    assert done.returncode == 2
    assert problem in done.stderr
    assert not workspace.started.exists()


@pytest.mark.skipif(not shutil.which("gdb"), reason="needs gdb")
def test_gdb_is_used_by_lines_for_its_standard_input(control_bench: ControlBench):
    script = "import time\\nprint('up', flush=True)\\ntime.sleep(1000)"
    gdb = "arm=gdb -q -nx -ex run --args"
    with control_bench.launch(f'py("{script}", name="arm")', "--prefix", gdb) as run:
        run.wait_for("[arm-1] up")
        pid = run.row("arm")["pid"]
        run.ask("kill", "arm", signal="SIGINT")  # gdb stops the program
        run.wait_for_log("arm", "received signal SIGINT")
        run.ask("send", "arm", text="bt 1")
        run.wait_for_log("arm", "#0 ")
        run.ask("send", "arm", text="kill")
        run.wait_for_log("arm", "killed]")
        run.ask("send", "arm", text="quit")
        wait_until(lambda: run.row("arm")["pid"] != pid, "the end of gdb")
        assert run.row("arm")["last_exit"]["returncode"] == 0
