"""Inherited signals, ignored or blocked: what is taken over, respected, and passed on."""

from __future__ import annotations

import os
import pty
import re
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from launcher.posix import dispositions, proc
from tests.support.benches import Bench
from tests.support.children import children_with
from tests.support.hostile_parent import with_signals
from tests.support.waiting import wait_until


def start(bench: Bench, command: Sequence[str]) -> subprocess.Popen[bytes]:
    with (bench.folder / "screen").open("wb") as screen:
        return subprocess.Popen(command, env=bench.env, stdout=screen, stderr=screen)


def screen(bench: Bench) -> str:
    return (bench.folder / "screen").read_text()


def wait_for(bench: Bench, text: str) -> None:
    wait_until(lambda: text in screen(bench), f"{text!r} on the screen")


def masks(text: str, name: str) -> dict[str, int]:
    """`SigIgn` and so on -> mask, of what a process of this name has shown of its status.

    Without 32 and 33, which belong to the C library: its posix_spawn leaves them ignored.
    """
    found = re.findall(rf"^\[{name}\] (Sig(?:Blk|Ign|Cgt)):\s*(\w+)$", text, re.M)
    return {field: int(mask, 16) & ~(3 << 31) for field, mask in found}


STATUS = 'cmd=["cat", "/proc/self/status"], output="screen"'
WAYS = {
    "plain": "",
    "folder": ', cwd="/"',
    "tty": ", emulate_tty=True",
    "limited": "",
    "folder-limited": ', cwd="/"',
}
SHELL = """ExecuteProcess(
    cmd=["cat /proc/self/status"], shell=True, output="screen", name="shell")"""
PYTHON = """ExecuteProcess(
    cmd=[sys.executable, "status.py"], cwd="FOLDER", output="screen", name="NAME")"""


def _showing(folder: Path) -> str:
    """Actions that start a program in every way; each shows its status."""
    (folder / "status.py").write_text("print(open('/proc/self/status').read())\n")
    shown = [f"ExecuteProcess({STATUS}{how}, name={name!r})" for name, how in WAYS.items()]
    python = PYTHON.replace("FOLDER", str(folder))
    return ", ".join([*shown, SHELL, *(python.replace("NAME", name) for name in ("warm", "cold"))])


def test_children_ignore_and_block_nothing_whatever_the_launcher_has_inherited(bench: Bench):
    actions = _showing(bench.folder)
    options = ["--warm", "--nice", "limited=0", "--nice", "folder-limited=0"]
    process = start(bench, with_signals(bench.command(actions, *options)))
    assert process.wait(60) == 0, screen(bench)
    text = screen(bench)
    for number, name in enumerate([*WAYS, "shell"], 1):
        assert masks(text, f"{name}-{number}") == {"SigBlk": 0, "SigIgn": 0, "SigCgt": 0}, name
    plain = subprocess.run(
        [sys.executable, str(bench.folder / "status.py")], capture_output=True, text=True
    ).stdout
    usual = masks(re.sub("^", "[plain] ", plain, flags=re.M), "plain")
    for name in ("warm-7", "cold-8"):
        assert masks(text, name) == usual, "as in any interpreter"


def test_helpers_ignore_the_signals_that_end_a_run(bench: Bench):
    terminal = bench.terminal('sh("echo ready; exec sleep 1000")')
    terminal.wait_for("ready")
    for program in ("watchdog.py", "launcher.control.console"):
        wait_until(
            lambda program=program: _ignores(terminal.pid, program), f"{program} ignores all"
        )
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


def _ignores(launcher: int, program: str) -> bool:
    """Whether this child ignores all of them."""
    pids = [child.pid for child in children_with(launcher, program)]
    ending = sum(1 << signum - 1 for signum in dispositions.ENDING)
    return any(int(proc.status_field(pid, "SigIgn"), 16) & ending == ending for pid in pids)


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM, signal.SIGQUIT])
def test_a_run_obeys_signals_that_were_ignored_and_blocked(bench: Bench, signum: int):
    process = start(bench, with_signals(bench.command('sh("echo ready; exec sleep 1000")')))
    wait_for(bench, "[sh-1] ready")
    process.send_signal(signum)
    assert process.wait(60) == 0
    assert bench.survivors() == []


def test_a_program_that_replaces_the_launcher_does_not_ignore_what_python_ignores(bench: Bench):
    words = ["run", "--prefix", "cat /proc/self/status", "group_gp1", "robot_1"]
    command = [sys.executable, "-m", "launcher", *words]
    process = start(bench, with_signals(command, ignored=[signal.SIGHUP, signal.SIGINT]))
    assert process.wait(60) == 0
    found = masks(re.sub("^", "[it] ", screen(bench), flags=re.M), "it")
    assert found == {"SigBlk": 0, "SigIgn": 1 << signal.SIGHUP - 1, "SigCgt": 0}


def test_exit_codes_are_known_where_sigchld_is_ignored(bench: Bench):
    command = bench.command('sh("exit 3"), sh("exit 0", cwd="/"), sh("kill -TERM $$")')
    process = start(bench, with_signals(command, ignored=[signal.SIGCHLD], blocked=[]))
    assert process.wait(60) == 1
    assert "exit code 3" in screen(bench)
    assert "SIGTERM" in screen(bench)
    assert "[INFO] [sh-2]: process has finished cleanly" in screen(bench)


SCRIPT = """
import launcher.api
from launch import LaunchDescription, LaunchService
from launch.actions import ExecuteProcess
import signal
signal.signal(signal.SIGCHLD, signal.SIG_IGN)
service = LaunchService()
service.include_launch_description(LaunchDescription([ExecuteProcess(cmd=["false"])]))
raise SystemExit(service.run())
"""


def test_a_script_that_ignores_sigchld_gets_exit_codes(bench: Bench):
    process = start(bench, [sys.executable, "-c", SCRIPT])
    process.wait(60)
    assert "process has died" in screen(bench)
    assert "exit code 1" in screen(bench)


# ---- nohup

GOES_ON = "echo ready; until [ -e {go} ]; do sleep 0.02; done; echo gone on; exec sleep 1000"


def test_sighup_is_respected_where_it_was_ignored(bench: Bench):
    go = bench.folder / "go"
    command = bench.command(f'sh("{GOES_ON.format(go=go)}")')
    process = start(bench, with_signals(command, ignored=[signal.SIGHUP], blocked=[]))
    wait_for(bench, "[sh-1] ready")
    process.send_signal(signal.SIGHUP)
    go.touch()
    wait_for(bench, "[sh-1] gone on")
    process.send_signal(signal.SIGTERM)
    assert process.wait(60) == 0
    assert "ended by: SIGTERM" in screen(bench)


def test_a_run_under_nohup_and_its_processes_survive_the_end_of_the_terminal(bench: Bench):
    go = bench.folder / "go"
    script = GOES_ON.format(go=go)
    command = ["nohup", *bench.command(f'sh("{script}"), sh("{script}", emulate_tty=True)')]
    pid, terminal = pty.fork()
    if pid == 0:
        try:
            os.chdir(bench.folder)
            os.execvpe(command[0], command, bench.env)
        finally:
            os._exit(127)
    log = bench.folder / "nohup.out"
    wait_until(lambda: log.exists() and log.read_text().count("] ready\n") == 2, "they run")
    os.close(terminal)  # the kernel sends SIGHUP to what is in the foreground
    go.touch()
    wait_until(lambda: log.read_text().count("] gone on\n") == 2, "they go on")
    os.kill(pid, signal.SIGTERM)
    _, status = os.waitpid(pid, 0)
    assert os.waitstatus_to_exitcode(status) == 0
    assert bench.survivors() == []
