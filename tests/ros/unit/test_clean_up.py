"""The destruction of the launcher's own nodes may hang in Fast DDS: it is limited."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

from launcher.ros.helpers.clean_up import limited_clean_up

SCRIPT = """
import threading, time
import launcher.ros.helpers.clean_up as clean_up

print("the output is written before")
with clean_up.limited_clean_up(cpu_s=0.2, wall_s=0.2 if {waits} else 60.0):
    time.sleep(600) if {waits} else sum(range(10**15))
"""


@pytest.mark.basic
@pytest.mark.parametrize(("waits", "signum"), [(True, signal.SIGALRM), (False, signal.SIGPROF)])
def test_a_process_whose_clean_up_hangs_dies_with_its_output_written(waits: bool, signum: int):
    script = SCRIPT.replace("{waits}", str(waits))
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, timeout=60, check=False
    )
    assert done.returncode == -signum
    assert done.stdout == b"the output is written before\n"


def test_an_ordinary_clean_up_gives_the_timers_back():
    before = signal.getitimer(signal.ITIMER_PROF)
    with limited_clean_up(cpu_s=100.0):
        assert 50.0 < signal.getitimer(signal.ITIMER_PROF)[0] <= 100.5
    assert signal.getitimer(signal.ITIMER_PROF) == before
