"""A mistake in the sources of a package, and what is reported of it."""

from __future__ import annotations

from typing import NamedTuple

from launcher.packages.distribution import or_default
from tests.workspace.unit.building.source_tree import MINIMUM, interface_package


class Case(NamedTuple):
    """Files of `src/`; `at` is the text of `where` that the caret points to, "" without one."""

    files: dict[str, str]
    where: str
    at: str
    message: str
    hint: str | None


CMAKE = f"{MINIMUM}project({{}})\nfind_package(ament_cmake REQUIRED)\n"


def msg(text: str, line: int, at: str, message: str, hint: str | None, name: str = "A") -> Case:
    """A message package with one file."""
    return of_file(f"msg/{name}.msg", text, line, at, message, hint)


def of_file(
    path: str, text: str, line: int | None, at: str, message: str, hint: str | None
) -> Case:
    where = f"src/m/{path}:{line}" if line else f"src/m/{path}"
    return Case(interface_package("m", {path: text}), where, at, message, hint)


FIELD = "lower case letters, digits and single underscores, beginning with a letter"
SOURCES = (
    "put its sources into src/, or install its wheel if it has one: "
    f"pip install ros-{or_default()}-{{}}"
)
ABSENT = "package '{}' is neither in the workspace nor in the environment"
