"""Which configuration of pytest the tests of a package get."""

from __future__ import annotations

import os

import pytest

from launcher.workspace.building.build_place import Place
from launcher.workspace.building.sources import Package
from launcher.workspace.testing import package_jobs

SECTION = "[tool.pytest.ini_options]\n"


def chosen(root):
    """The value of `-c` for the package src/p."""
    package = Package("p", f"{root}/src/p", "ament_python")
    (job,) = package_jobs.jobs([package], Place(str(root), f"{root}/src"), [])
    return job.command[job.command.index("-c") + 1]


@pytest.fixture
def root(tmp_path):
    """A workspace in a checkout that has a configuration."""
    (tmp_path / "pyproject.toml").write_text(SECTION, encoding="utf-8")
    (tmp_path / "ws/src/p").mkdir(parents=True)
    return tmp_path / "ws"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("pytest.ini", ""),
        ("pyproject.toml", SECTION),
        ("tox.ini", "[pytest]\n"),
        ("setup.cfg", "[metadata]\nname = p\n[tool:pytest]\n"),
    ],
)
def test_that_of_the_package_is_before_that_of_the_workspace(root, name, text):
    (root / "pytest.ini").touch()
    (root / "src/p" / name).write_text(text, encoding="utf-8")
    assert chosen(root) == f"{root}/src/p/{name}"


def test_files_of_other_tools_are_none(root):
    for name in ("setup.cfg", "tox.ini", "pyproject.toml"):
        (root / "src/p" / name).write_text("[tool.other]\n", encoding="utf-8")
    (root / "pytest.ini").touch()
    assert chosen(root) == f"{root}/pytest.ini"


def test_outside_of_the_workspace_none_is_looked_for(root):
    assert chosen(root) == os.devnull
