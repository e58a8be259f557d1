"""The completion in real shells, and what it imports."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pexpect
import pytest

from launcher.control.active_runs import wait_for_run
from tests.support.benches import TIMEOUT_S, Bench
from tests.support.repository import REPOSITORY

BIN = os.path.dirname(sys.executable)
LAUNCHER = f"{BIN}/launcher"


def script(shell: str) -> str:
    return subprocess.check_output([LAUNCHER, "completion", shell], text=True)


@pytest.mark.parametrize(
    ("typed", "completed"),
    [
        ("launcher pla\t", "launcher plan "),
        ("launcher plan sys\tstart_r\tf\t", "launcher plan system start_robot_2:=false "),
        ("launcher zz\t--len\t", r"launcher zz\ y.launch.py --lenient "),
        ("launcher 'zz\t", "launcher 'zz y.launch.py'"),
        ("launcher run group_gp1 moni\t", "launcher run group_gp1 monitor "),
    ],
)
def test_bash_completes_what_is_typed(tmp_path: Path, typed: str, completed: str):
    (tmp_path / "zz y.launch.py").write_text("")
    (tmp_path / "launch").symlink_to(REPOSITORY / "launch")
    (tmp_path / "completion").write_text(script("bash"))
    env = {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}", "PS1": "> ", "TERM": "dumb"}
    bash = pexpect.spawn(
        "bash",
        ["--norc", "--noprofile", "-i"],
        env=env,
        cwd=str(tmp_path),
        encoding="utf-8",
        timeout=60,
        dimensions=(24, 200),
    )
    bash.sendline("bind 'set enable-bracketed-paste off'; source ./completion; echo re''ady")
    bash.expect_exact("ready\r\n> ")
    for part in typed.split("\t")[:-1]:
        bash.send(part)
        bash.expect_exact(part)
        bash.send("\t")
    # The line as bash has it: it is echoed again when something is inserted at its beginning.
    bash.send("\x01echo [\x05]\r")
    bash.expect(r"\[launcher[^\r]*\]\r\n|\[ launcher[^\r]*\]\r\n")
    said = bash.after.strip()
    bash.close(force=True)
    assert said[1:-1].split() == completed.split()


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_the_script_can_be_read_by_its_shell(tmp_path: Path, shell: str):
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    (tmp_path / "completion").write_text(script(shell))
    subprocess.run([shell, "-n", str(tmp_path / "completion")], check=True)


def test_processes_of_a_running_launch_are_completed(bench: Bench):
    run = bench.start('sh("exec sleep 1001", name="sleeper"), sh("exec sleep 1002", name="other")')
    wait_for_run(run.pid, TIMEOUT_S)
    words = [LAUNCHER, "completion", "fish", "kill", "--run", str(run.pid), "sl"]
    assert subprocess.check_output(words, text=True, env=bench.env).startswith("sleeper-1\t")


# Each takes longer to import than Python takes to start.
SLOW = ("asyncio", "lark", "prompt_toolkit", "psutil", "rclpy", "rich", "yaml")


@pytest.mark.parametrize("line", ["pl", "kill --s", "topic echo --q", "system --re"])
def test_verbs_and_options_are_completed_without_what_takes_long_to_import(line: str):
    words = ("completion", "bash", f"launcher {line}", ":=")
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "launcher", *words],
        capture_output=True,
        text=True,
        check=True,
    )
    imported = {row.rpartition("|")[2].strip() for row in done.stderr.splitlines()}
    assert any(name.startswith("launcher.cli.completion.") for name in imported)
    assert imported.isdisjoint(SLOW)
    assert done.stdout
