"""Wall time of `python -m launcher plan` for a small file and for the fleet."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from benchmarks.contestant import REPOSITORY, python_s
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
                "small": partial(python_s, "-m", "launcher", "plan", str(small)),
                "fleet": partial(python_s, "-m", "launcher", "plan", str(FLEET)),
                "bare": partial(python_s, "-c", "pass"),
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
