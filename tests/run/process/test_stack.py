"""`stack`: what the threads of real processes are doing."""

from __future__ import annotations

import json
import os
import signal
import sys
from pathlib import Path
from typing import Any

import psutil
import pytest

from launcher.control.client import RefusedError
from launcher.run.stacks import py_spy
from tests.support.benches import ControlBench
from tests.support.controlled_run import TIMEOUT_S, ControlledRun, state_of
from tests.support.waiting import wait_until

TWO_THREADS = """
import threading, time
first, second = threading.Lock(), threading.Lock()
def left():
    with first:
        time.sleep(0.2)
        with second: pass
def right():
    with second:
        time.sleep(0.2)
        with first: pass
threading.Thread(target=left, name="left").start()
print("ready", flush=True)
right()
"""
WAIT = """
import time
def wait(depth, said='a\\x1b[2J'):
    print('ready', flush=True)
    time.sleep(1000)
wait(7)
"""
PROGRAM = 'ExecuteProcess(cmd=[sys.executable, "{file}"], name="{name}", output="screen"),'
NO_LOCALS = "no native calls and local variables: py-spy is not installed"
SLEEPER = 'sh("exec sleep 1000", name="sleeper"),'


@pytest.fixture
def deadlock(control_bench: ControlBench) -> str:
    """The action of a program of which two threads wait for each other."""
    file = control_bench.folder / "deadlock.py"
    file.write_text(TWO_THREADS)
    return PROGRAM.format(file=file, name="arm")


def stacks(run: ControlledRun, *names: str, **options: Any) -> list[dict[str, Any]]:
    return [
        one for each in run.ask("stack", *names, **options)["processes"] for one in each["stacks"]
    ]


def functions(dump: dict[str, Any]) -> dict[str, list[str]]:
    return {one["name"]: [frame["function"] for frame in one["frames"]] for one in dump["threads"]}


def in_deadlock(run: ControlledRun) -> dict[str, Any]:
    """The dump, once both threads wait."""
    found: list[dict[str, Any]] = []

    def waits() -> bool:
        found[:] = stacks(run, "arm")
        lines = [one["frames"][0]["line"] for one in found[0]["threads"] if one["frames"]]
        return sorted(lines) == [7, 11]

    wait_until(waits, "a deadlock")
    return found[0]


def test_all_threads_are_printed_the_main_thread_first(control_bench: ControlBench, deadlock: str):
    with control_bench.launch(deadlock) as run:
        run.wait_for("ready")
        dump = in_deadlock(run)
        assert dump["pid"] == run.row("arm")["pid"]
        assert functions(dump)["MainThread"] == ["right", "<module>"]
        assert functions(dump)["left"][0] == "left"
        assert dump["threads"][0]["name"] == "MainThread"
        text = run.shell("stack", "arm").stdout
        assert "MainThread (idle)\n    right (" in text
        assert "deadlock.py:11)" in text
        assert "waited" not in run.screen
        shell = run.shell("stack", "arm", "--json")
        assert json.loads(shell.stdout)["processes"][0]["stacks"][0]["pid"] == dump["pid"]


def test_local_variables_and_native_calls_are_shown_on_request(control_bench: ControlBench):
    file = control_bench.folder / "wait.py"
    file.write_text(WAIT, encoding="utf-8")
    with control_bench.launch(PROGRAM.format(file=file, name="arm")) as run:
        run.wait_for("ready")
        (dump,) = stacks(run, "arm", locals=True)
        assert dump["threads"][0]["frames"][0]["locals"]["depth"] == "7"
        text = run.ask_text("stack", "arm", locals=True)
        assert "        depth = 7\n" in text
        assert "\x1b" not in text
        (dump,) = stacks(run, "arm", native=True)
        assert len(dump["threads"][0]["frames"]) > 2


def test_the_python_below_a_shell_is_found(control_bench: ControlBench, deadlock: str):
    script = f"{sys.executable} {control_bench.folder}/deadlock.py; true"
    with control_bench.launch(f'sh("{script}", name="arm")') as run:
        run.wait_for("ready")
        dump = in_deadlock(run)
        assert dump["pid"] != run.row("arm")["pid"]


def test_a_suspended_process_is_looked_at_and_stays_suspended(
    control_bench: ControlBench, deadlock: str
):
    with control_bench.launch(deadlock) as run:
        run.wait_for("ready")
        in_deadlock(run)
        run.ask("pause", "arm")
        for native in (False, True):
            (dump,) = stacks(run, "arm", native=native)
            assert functions(dump)["MainThread"][-1] == "<module>"
        assert run.row("arm")["paused"]


def test_of_another_program_the_kernel_tells_what_its_threads_wait_for(control_bench: ControlBench):
    with control_bench.launch(SLEEPER) as run:
        found: list[dict[str, Any]] = []

        def sleeps() -> bool:
            found[:] = stacks(run, "sleeper")
            state = found[0]["threads"][0]["state"]
            return bool(
                found[0]["command"] == "sleep 1000" and state.startswith("state S (sleeping)")
            )

        wait_until(sleeps, "its sleep")
        (dump,) = found
        assert dump["problem"] == "this is no Python program"
        assert dump["hint"].startswith(f"gdb -p {dump['pid']} ")


def test_names_that_cannot_be_asked(control_bench: ControlBench):
    with control_bench.launch(f'{SLEEPER} sh("true", name="gone")') as run:
        wait_until(lambda: run.row("gone")["state"] == "EXITED", "its end")
        with pytest.raises(RefusedError, match=r"gone-2 is not running \(EXITED\)"):
            run.ask("stack", "gone")
        with pytest.raises(RefusedError, match="unknown process 'sleper'"):
            run.ask("stack", "sleper")
        assert "gone-2 is not running" in run.ask_text("stack", "*")
        assert run.shell("stack").returncode == 2


def test_without_py_spy_the_extra_is_named(control_bench: ControlBench, deadlock: str):
    control_bench.env[py_spy.VARIABLE] = ""
    with control_bench.launch(deadlock) as run:
        run.wait_for("ready")
        (dump,) = stacks(run, "arm")
        assert dump["problem"] == "py-spy is not installed"
        assert "pip install " in dump["hint"] and "[debug]" in dump["hint"]
        wait_until(
            lambda: "sleeping" in stacks(run, "arm")[0]["threads"][0]["state"], "the deadlock"
        )


def test_without_py_spy_a_warm_program_tells_its_stacks(control_bench: ControlBench, deadlock: str):
    control_bench.env[py_spy.VARIABLE] = ""
    with control_bench.launch(deadlock, "--warm") as run:
        run.wait_for("ready")
        dump = in_deadlock(run)
        assert dump["threads"][0]["tid"] == run.row("arm")["pid"]
        assert functions(dump)["MainThread"][:2] == ["right", "<module>"]
        assert functions(dump)["left"][0] == "left"
        (dump,) = stacks(run, "arm", locals=True)
        assert (len(dump["threads"]), dump["problem"]) == (2, NO_LOCALS)
        os.kill(dump["pid"], signal.SIGSTOP)
        wait_until(lambda: state_of(dump["pid"]) == psutil.STATUS_STOPPED, "the stop")
        (dump,) = stacks(run, "arm")
        assert (dump["problem"], dump["threads"][0]["frames"]) == ("py-spy is not installed", [])
        run.process.send_signal(signal.SIGINT)
        run.exit_code()


@pytest.mark.parametrize("program", ["/no/such/py-spy", "/bin/false", "/bin/true"])
def test_a_py_spy_that_does_not_work_is_told(control_bench: ControlBench, deadlock: str, program):
    control_bench.env[py_spy.VARIABLE] = program
    with control_bench.launch(deadlock) as run:
        run.wait_for("ready")
        (dump,) = stacks(run, "arm")
        assert "py-spy" in dump["problem"]
        assert run.row("arm")["state"] == "RUNNING"


NOT_DUMPABLE = "import ctypes, time; ctypes.CDLL(None).prctl(4, 0); print('hidden', flush=True)"


@pytest.mark.skipif(os.geteuid() != 0, reason="gives up a capability of root")
def test_what_the_kernel_forbids_is_told_with_its_repair(control_bench: ControlBench):
    """A process that is not dumpable may be looked at only with SYS_PTRACE."""
    file = control_bench.folder / "hidden.py"
    file.write_text(f"{NOT_DUMPABLE}; time.sleep(1000)\n")
    give_up = ["setpriv", "--inh-caps=-sys_ptrace", "--bounding-set=-sys_ptrace"]
    command = [*give_up, *control_bench.command(PROGRAM.format(file=file, name="arm"))]
    screen = control_bench.folder / "screen"
    with ControlledRun(
        command, env=control_bench.env, runtime=control_bench.runtime, screen=screen
    ) as run:
        run.wait_for("hidden")
        found = run.ask("stack", "arm")["processes"][0]["stacks"]
        assert found[0]["problem"].startswith(("py-spy may not look into it", "this is no Python"))
        assert found[0]["hint"]
        run.process.send_signal(signal.SIGINT)
        run.exit_code()


def test_a_process_that_dies_meanwhile_is_told(control_bench: ControlBench, deadlock: str):
    slow = control_bench.folder / "slow-py-spy"
    slow.write_text(
        "#!/bin/sh\necho $$ >$0.pid\nread line <$0.fifo\necho 'Error: gone' >&2\nexit 1\n"
    )
    slow.chmod(0o755)
    os.mkfifo(f"{slow}.fifo")
    control_bench.env[py_spy.VARIABLE] = str(slow)
    with control_bench.launch(deadlock) as run:
        run.wait_for("ready")
        with run.connect() as connection:
            connection.send("stack", ["arm"])
            wait_until(Path(f"{slow}.pid").exists, "the start of py-spy")
            run.ask("kill", "arm", signal="SIGKILL")
            Path(f"{slow}.fifo").write_text("go\n")
            answer = connection.read(TIMEOUT_S)
        (dump,) = answer["result"]["processes"][0]["stacks"]
        assert dump["problem"] == "it has ended meanwhile"


def test_a_hundred_requests_at_once_are_answered_and_leave_nothing(
    control_bench: ControlBench, deadlock: str
):
    with control_bench.launch(deadlock) as run:
        run.wait_for("ready")
        stacks(run, "arm")
        before = run.open_files()
        clients = [run.connect() for _ in range(8)]
        for number in range(96):
            clients[number % 8].send("stack", ["arm"], native=bool(number % 2))
        for client in clients[4:]:
            client.close()  # these leave without their answers
        for client in clients[:4]:
            with client:
                answers = [client.read(TIMEOUT_S) for _ in range(12)]
                assert all(answer["ok"] for answer in answers)
        assert run.row("arm")["state"] == "RUNNING"
        wait_until(lambda: run.open_files() <= before, "the end of all connections")


def test_the_run_ends_while_a_stack_is_read(control_bench: ControlBench, deadlock: str):
    hangs = control_bench.folder / "hangs"
    hangs.write_text("#!/bin/sh\necho $$ >$0.pid\nexec sleep 1000\n")
    hangs.chmod(0o755)
    control_bench.env[py_spy.VARIABLE] = str(hangs)
    with control_bench.launch(deadlock) as run:
        run.wait_for("ready")
        asking = run.shell_start("stack", "arm")
        wait_until(Path(f"{hangs}.pid").exists, "the start of py-spy")
        run.process.send_signal(signal.SIGINT)
        run.process.send_signal(signal.SIGINT)
        run.exit_code()
        asking.communicate(timeout=TIMEOUT_S)
        assert control_bench.survivors() == []
