"""The receive buffer of a socket of another process is enlarged from outside."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.ros.discovery.receive_buffers import SIZE_BYTES, enlarge

# Prints inode and size of its socket's buffer, and the size again when that was enlarged.
PROGRAM = """import os, socket
one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
size = lambda: one.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
{before}
print(os.fstat(one.fileno()).st_ino, size(), flush=True)
input()
print(size(), flush=True)
"""
SMALL, LARGE = "pass", f"one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, {SIZE_BYTES})"


@contextlib.contextmanager
def program(before: str) -> Iterator[subprocess.Popen[str]]:
    words = [sys.executable, "-c", PROGRAM.format(before=before)]
    with subprocess.Popen(
        words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        yield process


@pytest.mark.parametrize("before", [SMALL, LARGE])
def test_it_gets_what_the_kernel_allows(before: str):
    allowed = min(SIZE_BYTES, int(Path("/proc/sys/net/core/rmem_max").read_text()))
    with program(before) as process:
        assert process.stdout is not None
        inode, size = process.stdout.readline().split()
        assert enlarge(process.pid, {inode, "0"}) == {inode}
        enlarged, _ = process.communicate("\n", timeout=60)
    assert int(enlarged) == max(int(size), 2 * allowed)


def test_others_are_left_alone():
    with program(SMALL) as process:
        assert process.stdout is not None
        _, size = process.stdout.readline().split()
        assert enlarge(process.pid, {"0"}) == set()
        same, _ = process.communicate("\n", timeout=60)
    assert same.strip() == size
    assert enlarge(process.pid, {"0"}) == set()  # it is gone


def test_a_process_that_may_not_be_debugged_keeps_its_own(monkeypatch: pytest.MonkeyPatch):
    def refuse(pid: int) -> int:
        raise PermissionError

    with program(SMALL) as process:
        assert process.stdout is not None
        inode, size = process.stdout.readline().split()
        monkeypatch.setattr(os, "pidfd_open", refuse)
        assert enlarge(process.pid, {inode}) == {inode}
        same, _ = process.communicate("\n", timeout=60)
    assert same.strip() == size
