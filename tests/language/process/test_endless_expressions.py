"""Ctrl-C and SIGTERM end an expression that Python does not interrupt."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

EXPRESSION = "[print('now', flush=True), sum(range(10**12))]"
LAUNCH_FILE = f"""
from launch import LaunchDescription
from launch.actions import LogInfo
from launch.substitutions import PythonExpression

def generate_launch_description():
    return LaunchDescription([LogInfo(msg=PythonExpression({EXPRESSION!r}))])
"""
FILTER = f"""
import signal
from launcher.ros.topics.echo import compiled_filter
signal.signal(signal.SIGTERM, signal.default_int_handler)
compiled_filter({EXPRESSION!r})(None)
"""


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("place", ["launch file", "--filter"])
def test_a_signal_ends_an_endless_expression(place: str, signum: signal.Signals, tmp_path: Path):
    path = tmp_path / "endless.launch.py"
    path.write_text(LAUNCH_FILE, encoding="utf-8")
    words = ["-m", "launcher", str(path)] if place == "launch file" else ["-c", FILTER]
    run = subprocess.Popen([sys.executable, *words], stdout=subprocess.PIPE, text=True)
    try:
        assert run.stdout is not None
        assert any("now" in line for line in run.stdout)
        run.send_signal(signum)
        assert run.wait(60) == -signum
    finally:
        run.kill()
        run.communicate()
