"""Real core files of real crashes, wherever the kernel of this machine writes them."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from launcher.run.logs.core_file import CorePattern
from tests.support.benches import Bench

SEGFAULT = '"import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", name="arm"'
pytestmark = pytest.mark.skipif(
    bool(CorePattern.of_kernel().handler), reason="the kernel passes core dumps to a program"
)


def opening_commands(text: str) -> list[list[str]]:
    found = re.findall(r"to open it: (.+?)(?:, or for the Python stack: (.+))?$", text, re.M)
    return [shlex.split(command) for pair in found for command in pair if command]


def test_the_core_file_of_a_crash_is_named_and_the_commands_open_it(bench: Bench):
    actions = f'py({SEGFAULT}, cwd="{bench.folder}")'
    done = bench.run(actions, "--limit", "arm:core=unlimited")
    text = done.stdout.decode()
    assert "(SIGSEGV, core dumped)" in text, done.stderr
    gdb, py_spy, *again = opening_commands(text)
    assert again == [gdb, py_spy]  # in the report on the first failure
    core = Path(gdb[2])
    assert core.stat().st_size > 0
    assert Path(gdb[1]).name.startswith("python")
    if shutil.which("gdb"):
        opened = subprocess.run(
            [gdb[0], "-q", "-batch", "-ex", "bt", *gdb[1:]], capture_output=True, text=True
        )
        assert "terminated with signal SIGSEGV" in opened.stdout
    core.unlink()


def test_a_crash_below_a_shell_is_found_by_its_session(bench: Bench):
    actions = f"sh(\"cd {bench.folder}; (kill -SEGV $(exec sh -c 'echo $PPID')); exit 139\","
    done = bench.run(f'{actions} name="arm", cwd="{bench.folder}")', "--limit=arm:core=unlimited")
    text = done.stdout.decode()
    (gdb, *_) = opening_commands(text)
    assert "exit code 139" in text
    Path(gdb[2]).unlink()


def test_without_a_core_file_the_option_for_one_is_told_once(bench: Bench):
    options = "respawn=True, respawn_max_retries=2"
    done = bench.run(f"py({SEGFAULT}, {options})", "--limit", "arm:core=0")
    hint = "to get one: --limit arm:core=unlimited"
    *_, (_, report) = [line.split("]: ", 1) for line in done.stdout.decode().splitlines()]
    assert done.stdout.decode().count("[arm-1]: it left no core file, since their size") == 1
    assert done.stdout.decode().count(hint) == 2  # the second is in the report on the failure
    assert report.startswith("exit code 1")
