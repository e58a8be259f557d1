"""The documents agree with the code: exit codes, verbs, options, links and paths."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from launcher.base.command_help import help_text
from launcher.base.command_line import Command
from launcher.base.errors import ExitCode
from launcher.base.verb_table import CONTROL_VERBS, INTERNAL, TASK_OF, TASKS, VERBS
from launcher.cli.overview import control_verbs, overview
from launcher.launch.plan import plan_json
from launcher.launch.plan.planner import make_plan
from launcher.launch.verbs.launch import COMMAND
from tests.support.repository import DOCS, REPOSITORY, docs_page
from tools import command_reference, event_reference

README = (REPOSITORY / "README.md").read_text(encoding="utf-8")
VERBS_PAGE = docs_page("verbs")
CONTRIBUTING = (REPOSITORY / "CONTRIBUTING.md").read_text(encoding="utf-8")
NAMES = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")
ARCHITECTURE = docs_page("architecture")
CITATION = re.compile(r"CONFORMANCE (\d+\.\d+(?:,\s\d+\.\d+)*)")
DOCUMENTS = [*(REPOSITORY / name for name in NAMES), *sorted(DOCS.rglob("*.md"))]


def test_the_document_and_the_help_have_the_same_table_of_exit_codes():
    rows = dict(re.findall(r"^\| (\d+) \| ([^|]+) \|$", VERBS_PAGE, re.M))
    assert rows == {str(code.value): code.meaning for code in ExitCode}
    assert all(code.meaning in overview() for code in ExitCode)
    of_launch = {code for code in ExitCode if code.meaning in help_text(COMMAND)}
    assert of_launch == {*ExitCode} - {ExitCode.NOT_MET, ExitCode.NOT_READY}


def test_every_verb_has_help_and_is_documented():
    for verb, text in VERBS.items():
        assert (text in overview()) == (TASK_OF[verb] != INTERNAL)
        assert text in overview(is_whole=True)
        assert verb == "launch" or f"python -m launcher {verb} " in VERBS_PAGE


def test_the_control_verbs_are_those_of_their_table_and_documented():
    assert [name for name, _ in control_verbs()] == list(CONTROL_VERBS)
    for name, text in control_verbs():
        assert text in overview()
        assert f"python -m launcher {name} " in VERBS_PAGE


def test_every_verb_has_one_task():
    assert {*TASK_OF} == {*VERBS, *CONTROL_VERBS}
    assert {*TASK_OF.values()} == {*TASKS, INTERNAL}


def test_the_page_of_all_options_explains_each_option_once():
    items = re.findall(r"^- `.*$", command_reference.page(), re.M)
    assert len(items) == len(set(items))
    rows = {
        command_reference.item(option).strip()
        for command in command_reference.commands()
        for option in command.all_options
    }
    assert {*items} == rows


def test_the_page_of_all_options_names_those_of_every_verb():
    sections = dict(re.findall(r"^## (.+)\n((?:(?!## ).*\n?)*)", command_reference.page(), re.M))
    for command in command_reference.commands():
        groups = [title for title, _ in command.groups]
        named = sections[command.name]
        for option in () if command.commands else command.options:
            is_there = option.flags[-1] in named or option.flags == ("--debug",)
            assert is_there, (command.name, option.flags, groups)


def test_the_page_of_all_options_is_generated_from_the_tables():
    assert command_reference.PAGE.read_text(encoding="utf-8") == command_reference.page()


def test_the_page_of_all_events_is_generated_from_their_types():
    assert event_reference.PAGE.read_text(encoding="utf-8") == event_reference.page()


PAGES = (
    "running",
    "ros-verbs",
    "control",
    "smoke",
    "doctor",
    "console",
    "launch-files",
    "own-messages",
)
# Of colcon, docker, git, ROS and pytest, and one that is no option.
OF_OTHERS = {
    "--branch",
    "--build-type",
    "--depth",
    "--fast",
    "--filter",
    "--init",
    "--ipc",
    "--launch-args",
    "--launch-artifacts",
    "--ros-args",
    "--shm-size",
    "--sparse",
    "--symlink-install",
}


@pytest.mark.parametrize(
    "text", [README, *(docs_page(name) for name in PAGES)], ids=["README", *PAGES]
)
def test_options_that_a_document_names_exist(text: str):
    known = {flag for command in command_reference.commands() for flag in flags_of(command)}
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+\w", text))
    assert named - known - OF_OTHERS == set()


def flags_of(command: Command) -> set[str]:
    return {flag for option in command.all_options for flag in option.flags}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_links_between_documents_have_a_target(document: Path):
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", document.read_text(encoding="utf-8")):
        assert (document.parent / target).exists(), target


def test_every_make_target_that_a_document_names_exists():
    makefile = (REPOSITORY / "Makefile").read_text(encoding="utf-8")
    named = set(re.findall(r"^make (\w+)|`make (\w+)", README + CONTRIBUTING, re.M))
    for target in {a or b for a, b in named}:
        assert re.search(rf"^{target}:", makefile, re.M), target


def test_every_fact_cited_by_number_is_in_the_document():
    document = docs_page("ros2-behaviour")
    facts = set(re.findall(r'<a id="([\d.]+)"></a>\*\*\1 ', document))
    cited = {
        (number, path.relative_to(REPOSITORY))
        for folder in ("launcher", "group_gp1", "tests", "docs")
        for path in (REPOSITORY / folder).rglob("*.*")
        if path.suffix in (".py", ".md")
        for numbers in CITATION.findall(path.read_text(encoding="utf-8", errors="replace"))
        for number in re.findall(r"\d+\.\d+", numbers)
    }
    assert cited
    assert {(number, path) for number, path in cited if number not in facts} == set()


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_links_to_a_heading_name_one_that_exists(document: Path):
    for target, anchor in re.findall(
        r"\]\(([^)#:]*)#([^)]+)\)", document.read_text(encoding="utf-8")
    ):
        text = (document.parent / target if target else document).read_text(encoding="utf-8")
        headings = re.findall(r"^#+ (.+)$", text, re.M)
        assert anchor in [re.sub(r"[^\w\- ]", "", h).replace(" ", "-").lower() for h in headings]


def test_every_key_of_the_json_plan_is_documented():
    document = docs_page("plan-json")
    plan = plan_json.document(make_plan(str(REPOSITORY / "launch" / "system.launch.py"), []))
    keys = {*plan, *plan["processes"][0], *plan["arguments"][0]}
    assert {key for key in keys if f"`{key}`" not in document} == set()


def test_every_package_of_the_launcher_is_in_the_architecture():
    top = REPOSITORY / "launcher"
    packages = {f"{path.parent.name}/" for path in top.glob("*/__init__.py")}
    modules = {path.stem for path in top.glob("*.py")} - {"__init__", "setup"}
    assert {name for name in packages | modules if f"`{name}`" not in ARCHITECTURE} == set()


def test_every_path_in_the_architecture_exists():
    tops = ("launcher", "group_gp1", "launch", "tests", "tools", "benchmarks")
    paths = [REPOSITORY / top for top in tops]
    paths += [path for top in tops for path in (REPOSITORY / top).rglob("*") if path.name[0] != "_"]
    known = {f"/{path.relative_to(REPOSITORY).with_suffix('')}" for path in paths}
    named = set(re.findall(r"`([a-z_]+(?:/[a-z_]+)*(?:/|\.py|/[a-z_]+))`", ARCHITECTURE))
    endings = {name: f"/{name.rstrip('/').removesuffix('.py')}" for name in named}
    assert {n for n, end in endings.items() if not any(k.endswith(end) for k in known)} == set()


def test_no_tracked_file_has_conflict_markers():
    # As they are not to be in this file, they are put together.
    marks = [f"{sign * 7} ".encode() for sign in "<>"]
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=REPOSITORY, capture_output=True, check=True
    )
    paths = [REPOSITORY / name for name in listed.stdout.decode().split("\0") if name]
    assert paths
    bad = [
        f"{path}:{number}"
        for path in paths
        if path.is_file() and not path.is_symlink()
        for number, line in enumerate(path.read_bytes().split(b"\n"), 1)
        if line.startswith(tuple(marks))
    ]
    assert not bad


def test_every_change_has_a_name_and_a_type_that_the_changelog_has():
    settings = (REPOSITORY / "pyproject.toml").read_text(encoding="utf-8")
    types = "|".join(
        re.findall(r'^\[\[tool\.towncrier\.type\]\]\ndirectory = "(\w+)"', settings, re.M)
    )
    names = {path.name for path in (REPOSITORY / "changes").iterdir()} - {"README.md"}

    assert [name for name in names if not re.fullmatch(rf"\+[\w-]+\.({types})\.md", name)] == []
