"""A launch file with a mistake, and what is reported of it."""

from __future__ import annotations

import textwrap
from typing import NamedTuple

HEAD = """\
import os
from launch import Action, Condition, LaunchDescription, LaunchDescriptionEntity, Substitution
from launch.actions import *
from launch.conditions import *
from launch.substitutions import *
from launch_ros.actions import Node
"""


class Case(NamedTuple):
    """A launch file; `at` is the text that the caret points to; `words`: launch arguments."""

    text: str
    line: int
    at: str
    message: str
    hint: str
    suffix: str = "py"
    words: tuple[str, ...] = ()


def python(
    body: str, at: str, message: str, hint: str, *, words: tuple[str, ...] = (), plus: int = 0
) -> Case:
    """A Python file; the line is the one marked with `# here`, and `plus` further ones."""
    text = HEAD + textwrap.dedent(body)
    (number,) = [n for n, line in enumerate(text.splitlines(), start=1) if "# here" in line]
    return Case(text, number + plus, at, message, hint, words=words)


def described(entry: str) -> str:
    """A Python file with one entry in its description."""
    return f"""
    def generate_launch_description():
        return LaunchDescription([
            DeclareLaunchArgument('d', default_value='/tmp'),
            {entry}  # here
        ])
    """
