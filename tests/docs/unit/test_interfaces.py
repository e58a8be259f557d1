"""The page about interface packages has the commands and the table of the code."""

from __future__ import annotations

import re

import pytest

from launcher.packages import package_origins
from launcher.packages.package_origins import INSTRUCTIONS, SOURCES, clone_commands
from tests.support.repository import REPOSITORY

FILE = REPOSITORY / INSTRUCTIONS.removeprefix("see ")
PAGE = FILE.read_text(encoding="utf-8")
ROW = re.compile(r"^\| `(\w+)` \| \[(\S+)\]\((\S+)\), `(\S+)` \| ([^|]+) \|", re.MULTILINE)


@pytest.fixture(autouse=True)
def _jazzy(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page has the branches of Jazzy."""
    monkeypatch.setattr(package_origins, "or_default", lambda: "jazzy")


def test_the_table_has_every_package_with_its_repository_and_folder():
    rows = {name: (url, branch, folders) for name, _, url, branch, folders in ROW.findall(PAGE)}
    assert sorted(rows) == sorted(SOURCES)
    for name, (url, branch, folders) in rows.items():
        clone, *checkout = clone_commands(name)
        assert f" --branch {branch} " in clone
        assert f" {url} src/" in clone
        wanted = [
            f"`{folder}`" for line in checkout for folder in line.partition(" add ")[2].split()
        ]
        assert folders == (", ".join(wanted) or "all of it")


@pytest.mark.parametrize("package", ["example_interfaces", "tf2_msgs", "composition_interfaces"])
def test_the_commands_of_the_examples_are_those_that_are_printed(package: str):
    assert "\n".join(clone_commands(package)) in PAGE
