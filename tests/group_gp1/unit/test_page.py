"""The page that the course grades agrees with the fleet."""

from __future__ import annotations

import ast
import re

import pytest

from tests.support.repository import REPOSITORY

FOLDER = REPOSITORY / "group_gp1"
PAGE = (FOLDER / "README.md").read_text(encoding="utf-8")
MOST_WORDS = 1500
# What the course grades, as headings.
SECTIONS = (
    "Group members",
    "Scenario",
    "Topics and QoS",
    "Build and run",
    "Design decisions",
    "The late joiner",
    "The QoS mismatch",
    "The queue overflow",
    "The stall test",
)


def test_it_has_a_section_for_everything_that_is_graded_and_is_short():
    assert set(SECTIONS) <= set(re.findall(r"^## (.+)$", PAGE, re.M))
    assert len(re.findall(r"\w[^\s|]*", PAGE)) <= MOST_WORDS


def test_its_links_and_its_table_of_files_name_what_exists():
    targets = re.findall(r"\]\(([^)#:]+)", PAGE)
    table = PAGE.partition("| path | contents |")[2].partition("\n\n")[0]
    named = [one for row in re.findall(r"^\| (`.+?) \|", table, re.M) for one in row.split(", ")]
    targets += [name.removesuffix(" ...").strip("`") for name in named]
    assert len(targets) > 8
    assert [one for one in targets if not (FOLDER / one).exists()] == []


@pytest.mark.parametrize("topic", ["tasks", "status", "report"])
def test_its_table_has_the_depths_of_the_profiles(topic: str):
    names = (FOLDER / "qos.py").read_text(encoding="utf-8")
    depths = {
        ast.unparse(one.targets[0]): ast.unparse(one.value)
        for one in ast.parse(names).body
        if isinstance(one, ast.Assign)
    }
    rows = PAGE.partition(f"| `/fleet/{topic}` |")[2]
    assert re.findall(r"depth (\d+)", rows)[0] == depths[f"{topic.upper()}_DEPTH"]


def test_the_launch_arguments_that_it_names_are_those_of_the_launch_file():
    declared = set(
        re.findall(
            r"DeclareLaunchArgument\(\s*'(\w+)'",
            (REPOSITORY / "launch" / "system.launch.py").read_text(encoding="utf-8"),
        )
    )
    assert set(re.findall(r"(\w+):=", PAGE)) == declared
