"""Gaps in the heap of the preparing process, which forked processes would write to."""

from __future__ import annotations

import subprocess
import sys

import pytest

# Prints how many of 1000 blocks are allocated in gaps, as a forked process would.
PROGRAM = """
import ctypes, gc
from launcher.run.warm.preparing_service import fill_gaps

gc.disable()
libc = ctypes.CDLL(None)
libc.malloc.restype = ctypes.c_void_p
libc.malloc.argtypes = [ctypes.c_size_t]
libc.free.argtypes = [ctypes.c_void_p]
large = libc.malloc(100_000)
blocks = [libc.malloc(1000) for _ in range(4000)]
libc.free(large)
for block in blocks[::2]:
    libc.free(block)
{fill}
print(sum(libc.malloc(1000) < max(blocks) for _ in range(1000)))
"""


@pytest.mark.parametrize(("fill", "in_gaps"), [("fill_gaps()", 0), ("", 1000)])
def test_allocations_after_it_are_not_made_in_gaps(fill: str, in_gaps: int) -> None:
    command = [sys.executable, "-c", PROGRAM.format(fill=fill)]
    output = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout
    assert int(output) == in_gaps
