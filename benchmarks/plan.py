"""Wall time of `python -m launcher plan` for a small file and for the fleet."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

from benchmarks.contestant import REPOSITORY, python_environment
from benchmarks.harness import Row, interleaved, median, milliseconds, ratio, scratch

LIMIT_S = 0.15  # on an idle machine; a quarter of the time of `ros2 launch -p`
FLEET = REPOSITORY / "launch" / "system.launch.py"
SMALL = """from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("loud", default_value="true"),
        ExecuteProcess(cmd=["echo", LaunchConfiguration("loud")]),
        ExecuteProcess(cmd=["true"], condition=IfCondition(LaunchConfiguration("loud"))),
    ])
"""


def plan(runs: int) -> list[Row]:
    """The whole command, against the bare interpreter."""
    with scratch() as folder:
        small = Path(folder) / "small.launch.py"
        small.write_text(SMALL)
        found = interleaved(
            runs,
            {
                "small": lambda: _seconds("-m", "launcher", "plan", str(small)),
                "fleet": lambda: _seconds("-m", "launcher", "plan", str(FLEET)),
                "bare": lambda: _seconds("-c", "pass"),
            },
        )
    bare = found["bare"]
    detail = f"{milliseconds(found['small'])}, python -c pass {milliseconds(bare)}"
    return [
        Row("plan of a small file", ratio(found["small"], bare), "x", 3.0, detail),
        Row("the same, in seconds", median(found["small"]), "s", LIMIT_S, "on a quiet machine"),
        Row(
            "plan of the fleet", ratio(found["fleet"], bare), "x", 5.0, milliseconds(found["fleet"])
        ),
    ]


def _seconds(*words: str) -> float:
    begun = time.monotonic()
    subprocess.run(
        [sys.executable, *words],
        env=python_environment(),
        cwd=REPOSITORY,
        stdout=subprocess.DEVNULL,
        check=True,
    )
    return time.monotonic() - begun
