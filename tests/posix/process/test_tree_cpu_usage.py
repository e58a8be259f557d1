"""CPU usage of real process trees."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable

import pytest

from launcher.posix.tree_cpu_usage import TreeCpuUsage
from tests.support.waiting import wait_until

pytestmark = pytest.mark.thorough

BUSY = "while True: pass"
IN_A_THREAD = f"""
import signal, threading
threading.Thread(target=lambda: exec({BUSY!r}), daemon=True).start()
signal.pause()
"""
CHILD = [sys.executable, "-S", "-c"]
STARTS = {
    "the first thread": [*CHILD, BUSY],
    "another thread": [*CHILD, IN_A_THREAD],
    "a child": ["sh", "-c", f"{sys.executable} -S -c '{BUSY}'; true"],
}


@pytest.mark.parametrize("busy", STARTS)
def test_a_tree_is_busy_while_any_of_its_processes_is(busy: str):
    child = subprocess.Popen(STARTS[busy], start_new_session=True)
    try:
        _wait_for_share(child.pid, lambda share: share > 0.5)
        os.killpg(child.pid, signal.SIGSTOP)
        _wait_for_share(child.pid, lambda share: share == 0.0)
    finally:
        os.killpg(child.pid, signal.SIGKILL)
        child.wait()


def _wait_for_share(pid: int, fits: Callable[[float], bool]) -> None:
    exertion, looked_s = TreeCpuUsage(), time.monotonic()
    exertion.used_s(pid)  # what it used since its start

    def look() -> bool:
        nonlocal looked_s
        now = time.monotonic()
        if now - looked_s < 0.1:
            return False
        used_s, elapsed_s, looked_s = exertion.used_s(pid), now - looked_s, now
        return used_s is not None and fits(used_s / elapsed_s)

    wait_until(look, "as busy as it should be")


def test_an_ended_process_has_no_cpu_usage():
    child = subprocess.Popen(["true"])
    child.wait()
    assert TreeCpuUsage().used_s(child.pid) is None
