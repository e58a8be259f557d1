"""How programs become processes, with and without a working directory of their own.

With one, the work is left to `subprocess`; nobody may notice the difference.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.posix.spawn import execute, reap
from tests.support.benches import Bench

PATH = {"PATH": os.environ["PATH"]}
BOTH_WAYS = pytest.mark.parametrize("cwd", [None, "/"], ids=["posix_spawn", "subprocess"])


def outcome(
    *words: str, env: dict[str, str] = PATH, cwd: str | None = None
) -> tuple[int, str, tuple[int, bool]]:
    """(pid, what it wrote to stdout and stderr, how it ended)."""
    theirs, ours = os.pipe()
    stdin = os.open(os.devnull, os.O_RDONLY)
    try:
        pid = execute(words, env=env, streams=(stdin, ours, ours), cwd=cwd)
    finally:
        os.close(stdin)
        os.close(ours)
    with os.fdopen(theirs, "rb") as output:
        text = output.read().decode()
    pidfd = os.pidfd_open(pid)
    try:
        return pid, text, reap(pidfd)
    finally:
        os.close(pidfd)


@BOTH_WAYS
def test_a_process_leads_a_session_of_its_own(cwd: str | None):
    pid, text, _ = outcome("sh", "-c", "cut -d' ' -f6 /proc/$$/stat", cwd=cwd)
    assert int(text) == pid


@BOTH_WAYS
def test_its_end_is_a_code_or_a_negative_signal(cwd: str | None):
    assert outcome("sh", "-c", "exit 3", cwd=cwd)[2] == (3, False)
    assert outcome("sh", "-c", "kill -TERM $$", cwd=cwd)[2] == (-signal.SIGTERM, False)


@BOTH_WAYS
def test_it_ignores_no_signal_that_python_ignores(cwd: str | None):
    _, text, _ = outcome("grep", "SigIgn", "/proc/self/status", cwd=cwd)
    ignored = int(text.split()[1], 16)
    assert not ignored & 1 << (signal.SIGPIPE - 1)
    assert not ignored & 1 << (signal.SIGXFSZ - 1)


@BOTH_WAYS
def test_it_gets_the_environment_that_it_is_given_and_nothing_else(cwd: str | None):
    _, text, _ = outcome("env", env={**PATH, "WHO": "me"}, cwd=cwd)
    assert {line.partition("=")[0] for line in text.splitlines()} - {"PWD", "_"} == {"PATH", "WHO"}


@BOTH_WAYS
def test_a_program_is_looked_for_in_its_own_path(cwd: str | None, tmp_path: Path):
    refused, found = tmp_path / "refused", tmp_path / "found"
    for folder, mode in ((refused, 0o644), (found, 0o755)):
        folder.mkdir()
        (folder / "tool").write_text("#!/bin/sh\necho here\n")
        (folder / "tool").chmod(mode)
    env = {"PATH": f"{tmp_path}:{refused}:{found}"}
    assert outcome("tool", env=env, cwd=cwd)[1] == "here\n"


@BOTH_WAYS
def test_a_missing_program_and_one_without_permission_give_different_errors(
    cwd: str | None, tmp_path: Path
):
    with pytest.raises(FileNotFoundError):
        outcome("tool", env={"PATH": f"{tmp_path}:/no/such/folder"}, cwd=cwd)
    (tmp_path / "tool").touch(mode=0o644)
    with pytest.raises(PermissionError):
        outcome("tool", env={"PATH": f"{tmp_path}:/no/such/folder"}, cwd=cwd)


def test_it_runs_in_the_working_directory_that_it_is_given(tmp_path: Path):
    assert outcome("pwd", "-P", cwd=str(tmp_path))[1] == f"{tmp_path.resolve()}\n"
    with pytest.raises(FileNotFoundError):
        outcome("pwd", cwd=str(tmp_path / "missing"))


def test_it_inherits_no_descriptor_that_the_launcher_was_started_with(bench: Bench):
    theirs, ours = os.pipe()
    try:
        done = subprocess.run(
            bench.command('sh("ls /proc/$$/fd")'),
            env=bench.env,
            pass_fds=(ours,),
            capture_output=True,
            timeout=60,
        )
    finally:
        os.close(theirs)
        os.close(ours)
    assert re.findall(rb"^\[sh-1\] (\d+)$", done.stdout, re.M) == [b"0", b"1", b"2"]


# A process that writes much, and others that write seldom, whose last lines are kept for long.
MANY_LINES = """
import os
from launcher.output.lines import LineBuffer, LogRing
from launcher.posix.spawn import read_stream

def pages():
    return int(open("/proc/self/statm").read().split()[1])

theirs, ours = os.pipe()
rings = [LogRing() for _ in range(4)]
buffers = [LineBuffer() for _ in rings]
for number in range(40_000):
    for place, (ring, buffer) in enumerate(zip(rings, buffers)):
        if number % 40**place == 0:
            os.write(ours, b"y" * (50 + number * 7 % 450) + b"\\n")
            lines, _ = buffer.feed(read_stream(theirs))
            ring.append("both", 0.0, lines)
    if number == 2_000:
        before = pages()
print((pages() - before) * os.sysconf("SC_PAGE_SIZE"))
"""


def test_the_memory_of_lines_that_are_forgotten_is_used_again():
    done = subprocess.run([sys.executable, "-c", MANY_LINES], capture_output=True, check=True)
    assert int(done.stdout) < 2_000_000, done.stdout


# A flood: each read is prefixed twice, for the screen and for the log file.
FLOOD = """
import os, resource
from launcher.output.lines import with_prefix
from launcher.posix.spawn import READ_BYTES, read_stream

theirs, ours = os.pipe()
block = b"a line of some length\\n" * READ_BYTES
for number in range(1_000):
    os.write(ours, block[:READ_BYTES])
    chunk = read_stream(theirs)
    with_prefix(b"[name] ", chunk)
    with_prefix(b"0123456789.0123456 [name] ", chunk)
    if number == 100:
        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def test_a_flood_does_not_take_its_memory_from_the_kernel_again_for_each_read():
    done = subprocess.run([sys.executable, "-c", FLOOD], capture_output=True, check=True)
    assert int(done.stdout) < 900, done.stdout


KEEPING = """
import resource
from launcher.posix.allocator import keep_freed_memory

keep_freed_memory()
part = b"x" * 8_000_000
for number in range(40):
    whole = b"".join((part, b"y"))
    del whole
    if number == 3:
        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def test_large_buffers_are_used_again_where_freed_memory_is_kept():
    done = subprocess.run([sys.executable, "-c", KEEPING], capture_output=True, check=True)
    assert int(done.stdout) < 2_000, done.stdout  # one of them has 2,000 pages
