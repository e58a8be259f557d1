"""Mistakes that are reported before anything is compiled: message, place, caret and hint."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.errors import ExitCode
from launcher.workspace.building import checks, sources
from launcher.workspace.building.sources.source_text import SourceError, SourceWarning
from tests.workspace.unit.building.mistakes import (
    cmake_files,
    interface_files,
    interface_lists,
    manifests,
    setup_files,
)
from tests.workspace.unit.building.mistakes.cases import ABSENT, Case
from tests.workspace.unit.building.source_tree import python_package, write

TABLES = (interface_files, interface_lists, cmake_files, manifests, setup_files)
ERRORS = {name: case for table in TABLES for name, case in table.ERRORS.items()}
WARNINGS = {name: case for table in TABLES for name, case in table.WARNINGS.items()}


def problems_of(case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[SourceError]:
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "src", case.files)
    return checks.check(sources.find(["src"]))


def assert_matches(problem: SourceError, case: Case) -> None:
    message = case.message
    if "{syntax}" in message:  # differs between versions of Python
        message = "syntax error: " + problem.message.removeprefix("syntax error: ")
    assert (problem.message, problem.where, problem.hint) == (message, case.where, case.hint)
    if case.at:
        assert problem.source_line is not None
        assert problem.column is not None
        assert problem.source_line[problem.column - 1 :].startswith(case.at)
    else:
        assert problem.column is None


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # catkin_pkg uses old names
@pytest.mark.parametrize("name", ERRORS)
def test_a_mistake_is_reported_alone(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    case = ERRORS[name]

    found = checks.errors(problems_of(case, tmp_path, monkeypatch))

    assert len(found) == 1, [problem.render() for problem in found]
    assert_matches(found[0], case)
    assert found[0].exit_code is ExitCode.USAGE
    assert found[0].render().startswith("error: ")


@pytest.mark.parametrize("name", WARNINGS)
def test_what_is_built_but_not_as_meant(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    case = WARNINGS[name]

    (problem,) = problems_of(case, tmp_path, monkeypatch)

    assert isinstance(problem, SourceWarning)
    assert_matches(problem, case)
    assert problem.render().startswith("warning: ")


def test_missing_dependencies_are_reported_although_their_names_are_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    files = python_package("p", "<depend>my_own_msgs</depend>", "<depend>own_msgs</depend>")

    found = problems_of(Case(files, "", "", "", None), tmp_path, monkeypatch)

    assert [one.message for one in found] == [
        ABSENT.format(name) for name in ("my_own_msgs", "own_msgs")
    ]
