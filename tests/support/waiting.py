"""Wait for a condition, or for the end of a process."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from tests.support.node_process import without_complaints

LOOK_S = 0.02


def wait_until(fact: Callable[[], object], what: str, timeout_s: float = 60.0) -> None:
    """Poll until the fact holds; AssertionError at the deadline."""
    deadline = time.monotonic() + timeout_s
    while not fact():
        assert time.monotonic() < deadline, f"not within {timeout_s} s: {what}"
        time.sleep(LOOK_S)


def rest_of(process: subprocess.Popen[str], timeout_s: float = 60.0) -> tuple[str, str]:
    """What a process still prints to the pipes stdout and stderr, and wait for its end.

    For a process whose lines were read before: `communicate` loses what they left in the buffer.
    The complaints of Fast DDS are left out.
    """
    with ThreadPoolExecutor() as pool:
        out, err = (
            pool.submit(pipe.read if pipe else str) for pipe in (process.stdout, process.stderr)
        )
        try:
            process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
        return without_complaints(out.result()), without_complaints(err.result())
