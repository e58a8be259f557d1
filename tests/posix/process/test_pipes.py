"""Wide pipes, of a user with the limits of the kernel."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

import pytest

# As root there are no limits: it becomes a user that nothing else is running as.
USER = """
import fcntl, json, os
from launcher.posix import pipes
limit = int(open("/proc/sys/fs/pipe-user-pages-soft").read()) * os.sysconf("SC_PAGE_SIZE")
if os.geteuid() == 0:
    os.setresuid(*[60_000 + os.getpid() % 5_000] * 3)
size = lambda pipe: fcntl.fcntl(pipe[0], fcntl.F_GETPIPE_SZ)
"""
MANY = """
several = [os.pipe() for _ in range(limit // (1 << 18))]
usual = size(several[0])
for pipe in several:
    pipes.widen(pipe[0], 1 << 20)
print(json.dumps([limit, usual, [size(pipe) for pipe in several]]))
for pipe in several[:-1]:
    os.close(pipe[0]), os.close(pipe[1])
pipes.widen(several[-1][0], 1 << 20)
print(json.dumps(size(several[-1])))
"""
FULL = """
full = []
try:
    while True:
        full.append(os.pipe())
        fcntl.fcntl(full[-1][0], fcntl.F_SETPIPE_SZ, 1 << 20)
except PermissionError:
    pass
before = size(full[-1])
pipes.widen(full[-1][0], 1 << 20)
print(json.dumps(size(full[-1]) == before))
"""


def _printed(script: str) -> list[Any]:
    words = [sys.executable, "-c", USER + script]
    output = subprocess.run(words, env=os.environ, capture_output=True, check=True).stdout
    return [json.loads(line) for line in output.splitlines()]


def test_wide_pipes_take_a_share_of_the_limit_until_they_are_closed():
    (limit, usual, sizes), later = _printed(MANY)
    assert sizes == sorted(sizes, reverse=True)
    assert (sizes[0], sizes[-1]) == (1 << 20, usual)
    assert limit / 8 < sum(sizes) - len(sizes) * usual <= limit / 4
    assert later == 1 << 20


@pytest.mark.alone  # other tests of a user who is not root share the limit
def test_a_pipe_stays_as_it_is_if_the_user_has_reached_the_limit():
    assert _printed(FULL) == [True]
