"""Launch files whose texts would fill the memory: one sentence, with the place."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.language.substitution import MAX_TEXT
from launcher.launch.plan.planner import make_plan

DOUBLED = '<let name="a" value="xxxxxxxxxx"/>\n' + '<let name="a" value="$(var a)$(var a)"/>\n' * 40
XML = {
    "doubled": (DOUBLED, "the text of LaunchConfig('a') + LaunchConfig('a') has more than"),
    "doubled in the environment": (
        '<set_env name="A" value="xxxxxxxxxx"/>\n'
        + '<append_env name="A" value="$(env A)"/>\n' * 40,
        "has more than",
    ),
    "the output of a command": (
        """<let name="a" value="$(command 'yes')"/>""",
        "the text of a command has more than",
    ),
    "standard error of a command": (
        """<let name="a" value="$(command 'sh -c \\'exec yes >&amp;2\\'')"/>""",
        "the text of a command has more than",
    ),
    "a value": (
        f"""<let name="a" value="$(eval '\\' \\'.ljust({MAX_TEXT + 1})')"/>""",
        "the text of PythonExpr(",
    ),
}


@pytest.mark.parametrize(("text", "message"), XML.values(), ids=XML)
def test_a_text_that_grows_without_bound_is_an_error_with_its_place(
    tmp_path: Path, text: str, message: str
):
    path = tmp_path / "large.launch.xml"
    path.write_text(f"<launch>\n{text}\n</launch>\n", encoding="utf-8")
    error = make_plan(str(path), []).error
    assert error is not None
    fault = error.fault
    assert message in fault.message
    assert fault.where is not None and fault.where.startswith(f"{path}:")
    assert len(fault.render()) < 2000


def test_a_device_without_an_end_is_not_read_for_ever(tmp_path: Path):
    path = tmp_path / "large.launch.py"
    path.write_text(
        "from launch import LaunchDescription\n"
        "from launch.actions import LogInfo\n"
        "from launch.substitutions import FileContent\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([LogInfo(msg=FileContent('/dev/zero'))])\n"
    )
    error = make_plan(str(path), []).error
    assert error is not None and "FileContent('/dev/zero') has more than" in error.fault.message


def test_a_text_of_the_size_of_a_large_robot_is_none_of_that(tmp_path: Path):
    (tmp_path / "robot.urdf").write_text("x" * (MAX_TEXT // 2))
    path = tmp_path / "large.launch.xml"
    command = f"cat {tmp_path}/robot.urdf"
    path.write_text(f"""<launch><let name="a" value="$(command '{command}')"/></launch>""")
    assert make_plan(str(path), []).error is None
