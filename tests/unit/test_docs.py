"""The documents say what is true."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from launcher.cli import CONTROL_VERBS, VERBS, control_verbs, overview
from launcher.command_help import help_text
from launcher.command_line import Command
from launcher.commands.launch import COMMAND
from launcher.errors import ExitCode
from tools import command_reference

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
NAMES = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")
DOCUMENTS = [*(ROOT / name for name in NAMES), *sorted((ROOT / "docs").glob("*.md"))]


def test_readme_and_help_have_the_same_table_of_exit_codes():
    rows = dict(re.findall(r"^\| (\d+) \| ([^|]+) \|$", README, re.M))
    assert {str(code.value): code.meaning for code in ExitCode}.items() <= rows.items()
    assert all(
        code.meaning in text for code in ExitCode for text in (overview(), help_text(COMMAND))
    )


def test_every_verb_has_help_and_stands_in_the_readme():
    for verb, text in VERBS.items():
        assert text in overview()
        assert verb == "launch" or f"python -m launcher {verb} " in README


def test_the_verbs_about_a_run_are_those_of_their_table_and_stand_in_the_readme():
    assert tuple(name for name, _ in control_verbs()) == CONTROL_VERBS
    for name, text in control_verbs():
        assert text in overview()
        assert f"python -m launcher {name} " in README


def test_the_page_of_all_options_is_what_the_tables_say():
    assert command_reference.PAGE.read_text(encoding="utf-8") == command_reference.page()


PAGES = ("running", "ros-verbs", "control", "smoke", "doctor", "console", "launch-files")
# Of colcon, docker, ROS and pytest, and one that is no option.
OF_OTHERS = {"--symlink-install", "--shm-size", "--ros-args", "--launch-artifacts", "--fast"}


@pytest.mark.parametrize("page", [ROOT / "README.md", *(ROOT / f"docs/{one}.md" for one in PAGES)])
def test_options_that_a_document_names_exist(page: Path):
    known = {flag for command in command_reference.commands() for flag in flags_of(command)}
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+\w", page.read_text(encoding="utf-8")))
    assert named - known - OF_OTHERS == set()


def flags_of(command: Command) -> set[str]:
    return {flag for option in command.all_options for flag in option.flags}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_between_documents_lead_somewhere(document: Path):
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", document.read_text(encoding="utf-8")):
        assert (document.parent / target).exists(), target


def test_every_make_target_that_the_readme_names_exists():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    named = set(re.findall(r"^make (\w+)|`make (\w+)", README, re.M))
    for target in {a or b for a, b in named}:
        assert re.search(rf"^{target}:", makefile, re.M), target
