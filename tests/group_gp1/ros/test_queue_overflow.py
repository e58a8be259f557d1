"""The queue overflow experiment, short, as its command runs it."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from tests.support.repository import REPOSITORY

pytestmark = pytest.mark.thorough


def test_the_slow_robot_loses_tasks_at_a_high_rate():
    command = [sys.executable, "-m", "group_gp1.queue_overflow", "--case", "6:1", "--seconds", "6"]
    run = subprocess.run(
        command, cwd=REPOSITORY, capture_output=True, text=True, timeout=300, check=False
    )
    rate, depth, assigned, executed, lost, share = re.findall(r"\d+", run.stdout)[-6:]

    assert run.returncode == 0, run.stderr
    assert (rate, depth) == ("6", "1")
    assert int(assigned) > int(executed)
    assert 2 <= int(executed) <= 8
    assert int(lost) == int(assigned) - int(executed)
    assert int(share) >= 30
