"""`debug`: real programs under a real debugpy, with an editor that attaches."""

from __future__ import annotations

import socket

import psutil
import pytest

from launcher.control.client import RefusedError
from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun
from tests.support.dap import DapClient
from tests.support.waiting import wait_until

SCRIPT = """import os, sys, time
print("argv", sys.argv[1:], __name__, flush=True)
time.sleep(1000)
"""


@pytest.fixture
def arm(control_bench: ControlBench) -> str:
    """The action of a program that prints its arguments."""
    file = control_bench.folder / "arm.py"
    file.write_text(SCRIPT)
    words = f'sys.executable, "{file}", "a b", "--x"'
    return f'ExecuteProcess(cmd=[{words}], name="arm", output="screen", respawn=True),'


def lines_of(run: ControlledRun) -> int:
    return run.screen.count("argv ['a b', '--x'] __main__")


def attach(address: str) -> None:
    host, _, port = address.rpartition(":")
    with DapClient(host, int(port)) as editor:
        editor.attach()


def test_it_waits_for_an_editor_runs_on_with_it_and_a_restart_is_normal(
    control_bench: ControlBench, arm: str
):
    with control_bench.launch(arm) as run:
        run.wait_for("argv")
        before = run.row("arm")["pid"]
        found = run.ask("debug", "arm")
        row = run.row("arm")
        assert row["pid"] == found["pid"] != before
        assert row["debugger"] == found["address"]
        assert found["configuration"]["connect"]["port"] == int(found["address"].split(":")[1])
        assert lines_of(run) == 1
        assert "debugger at 127.0.0.1:" in run.shell("ps").stdout
        attach(found["address"])
        wait_until(lambda: lines_of(run) == 2, "that it runs on")
        (info,) = run.ask("info", "arm")["processes"]
        assert "debugpy" in info["cmd"]
        run.ask("restart", "arm")
        wait_until(lambda: lines_of(run) == 3, "its normal start")
        assert run.row("arm")["debugger"] is None
        assert "debugpy" not in run.ask("info", "arm")["processes"][0]["cmd"]
        run.ask("quit")
        assert run.exit_code() == 0
    assert control_bench.survivors() == []


@pytest.mark.thorough
def test_without_waiting_at_a_port_of_ones_own_from_a_shell(control_bench: ControlBench, arm: str):
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    with control_bench.launch(arm) as run:
        for _ in range(2):  # the second takes over the port of the first
            text = run.shell("debug", "arm", "--no-wait", "--port", str(port)).stdout
            assert f"arm-1 runs, and accepts a debugger at 127.0.0.1:{port} (pid " in text
            assert f'"port": {port}' in text
            run.wait_for_log("arm", "argv")
        attach(f"127.0.0.1:{port}")


@pytest.mark.thorough
def test_it_can_be_stopped_while_it_waits_and_dies_into_a_normal_restart(
    control_bench: ControlBench, arm: str
):
    with control_bench.launch(arm) as run:
        run.ask("debug", "arm")
        assert "stopped in" in run.ask_text("stop", "arm")
        pid = run.ask("debug", "arm")["pid"]
        psutil.Process(pid).kill()  # its policy restarts it, without the debugger
        wait_until(lambda: run.row("arm")["debugger"] is None, "its end")
        wait_until(lambda: run.row("arm")["state"] == "RUNNING", "its restart")
        run.ask("debug", "arm")
        run.process.terminate()
        run.exit_code()
    assert control_bench.survivors() == []


@pytest.mark.thorough
def test_changes_of_files_and_of_the_launch_file_leave_it_as_it_is(control_bench: ControlBench):
    script = control_bench.folder / "node.py"
    script.write_text(SCRIPT)
    action = f'ExecuteProcess(cmd=[sys.executable, "{script}", "{{}}"], name="{{}}"),'
    first = action.format("one", "arm") + action.format("one", "leg")
    with control_bench.launch(first, "--watch") as run:
        wait_until(lambda: all(row["files"] for row in run.ask("watch")["processes"]), "files")
        pid, leg = run.ask("debug", "arm")["pid"], run.row("leg")["pid"]
        script.write_text(SCRIPT + "# changed\n")
        run.wait_for("node.py changed: leg-2 restarts")
        run.wait_for("node.py changed: arm-1 runs on with what it has loaded, under a debugger")
        wait_until(lambda: run.row("leg")["pid"] not in (None, leg), "the restart of the other")
        control_bench.command(action.format("two", "arm") + action.format("one", "leg"))
        run.wait_for("not restarted, under a debugger: arm-1")
        text = run.ask_text("reload")
        assert "arm-1 is under a debugger and runs on as it is" in text
        assert run.row("arm")["pid"] == pid
        run.ask("restart", "arm")
        assert {one["change"] for one in run.ask("reload")["processes"]} == {"changed", "same"}
        assert run.ask("info", "arm")["processes"][0]["cmd"][-1] == "two"


@pytest.mark.thorough
def test_a_budget_is_told_but_not_enforced(control_bench: ControlBench, arm: str):
    options = ("--budget", "arm:memory=1M,for=1,action=restart")
    with control_bench.launch(arm.replace("arm.py", "late.py"), *options) as run:
        (control_bench.folder / "late.py").write_text("import time; time.sleep(1000)")
        pid = run.ask("debug", "arm")["pid"]
        run.wait_for("nothing is done, since it is under a debugger")
        sample = run.ask("events")["events"][-1]
        wait_until(lambda: run.ask("events")["events"][-1] != sample, "the next sample")
        assert run.row("arm")["pid"] == pid


@pytest.mark.parametrize(
    ("action", "says"),
    [
        ('sh("sleep 1000", name="arm")', "debugpy runs Python programs only"),
        ('py("import time", name="arm")', "the option '-c'"),
        ('ExecuteProcess(cmd=["sleep 1000"], shell=True, name="arm")', "command of a shell"),
    ],
)
def test_other_programs_are_refused_with_the_line_for_gdb(
    control_bench: ControlBench, action: str, says: str
):
    with control_bench.launch(f'{action}, sh("exec sleep 1000")') as run:
        with pytest.raises(RefusedError, match=says) as refused:
            run.ask("debug", "arm")
        assert "--prefix 'arm=gdb -ex run --args'" in (refused.value.hint or "")


def test_mistakes_are_refused_and_nothing_is_restarted(control_bench: ControlBench, arm: str):
    with control_bench.launch(arm) as run, socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        run.wait_for("argv")
        pid = run.row("arm")["pid"]
        for options, says in (
            ({"port": taken.getsockname()[1]}, "Address already in use"),
            ({"port": 70000}, "from 1 to 65535"),
            ({"port": -1}, "whole number"),
        ):
            with pytest.raises(RefusedError, match=says):
                run.ask("debug", "arm", **options)
        with pytest.raises(RefusedError, match="unknown process"):
            run.ask("debug", "amr")
        assert run.row("arm")["pid"] == pid


def test_without_debugpy_the_extra_is_named(control_bench: ControlBench, arm: str):
    hidden = control_bench.folder / "hidden/debugpy.py"
    hidden.parent.mkdir()
    hidden.with_name("sitecustomize.py").write_text(
        "import importlib.util as util\nfind = util.find_spec\n"
        "util.find_spec = lambda name, *more: None if name == 'debugpy' else find(name, *more)\n"
    )
    control_bench.env["PYTHONPATH"] = str(hidden.parent)
    with control_bench.launch(arm) as run:
        with pytest.raises(RefusedError, match="needs the Python package 'debugpy'") as refused:
            run.ask("debug", "arm")
        assert "[debug]" in (refused.value.hint or "")


def test_a_program_that_ends_before_the_debugger_listens_is_told(
    control_bench: ControlBench, arm: str
):
    """Its debugpy is one that does nothing."""
    fake = control_bench.folder / "fake/debugpy.py"
    fake.parent.mkdir()
    fake.write_text("raise SystemExit(3)")
    control_bench.env["PYTHONPATH"] = str(fake.parent)
    says = "ended before debugpy listened"
    with control_bench.launch(arm) as run, pytest.raises(RefusedError, match=says):
        run.ask("debug", "arm")
