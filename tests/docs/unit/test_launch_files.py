"""docs/reference/launch-files.md lists every warning, class and option."""

from __future__ import annotations

import ast
import importlib
import re
from pathlib import Path

import pytest

from launcher.base.command_help import help_text
from launcher.language.actions import timer
from launcher.language.compat import vocabulary
from launcher.language.diagnostics import ros2_quirks
from launcher.launch.verbs import args, launch, plan
from tests.support.repository import docs_page

TEXT = docs_page("launch-files")
SMALL_WORDS = 12  # pieces of a message that are shorter tell nothing


def warnings_of(module: object) -> list[str]:
    """The fixed pieces of what a module warns about."""
    tree = ast.parse(Path(str(vars(module)["__file__"])).read_text(encoding="utf-8"))
    pieces: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            texts = [v.value for v in node.values if isinstance(v, ast.Constant)]
            pieces += [text.strip(" :") for text in texts if len(text.strip(" :")) > SMALL_WORDS]
    return pieces


@pytest.mark.parametrize("piece", warnings_of(ros2_quirks))
def test_every_warning_is_documented(piece: str):
    assert piece in TEXT


def test_the_timer_that_never_fires_is_documented():
    assert any(piece in TEXT for piece in warnings_of(timer) if "never fires" in piece)


@pytest.mark.parametrize(
    "module",
    [
        "launch.actions",
        "launch.substitutions",
        "launch.conditions",
        "launch_ros.actions",
        "launch_ros.substitutions",
        "launch_ros.descriptions",
    ],
)
def test_every_class_of_the_launch_api_is_documented(module: str):
    with vocabulary():
        names = importlib.import_module(module).__all__
    named = [
        name for name in names if name[0].isupper() and not name.endswith(("Error", "Failure"))
    ]
    assert [name for name in named if not re.search(rf"\b{name}\b", TEXT)] == []


@pytest.mark.parametrize("option", ["--lenient", "--json", "--evaluation-timeout", "--debug"])
def test_options_of_launch_files_are_documented_and_in_the_help(option: str):
    assert option in TEXT
    assert option in help_text(plan.COMMAND)
    assert option == "--json" or option in help_text(launch.COMMAND)
    assert option not in ("--debug", "--evaluation-timeout") or option in help_text(args.COMMAND)
