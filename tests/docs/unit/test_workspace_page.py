"""The commands of docs/guides/own-messages.md and of the README are accepted."""

from __future__ import annotations

import importlib
import re
import shlex

import pytest

from launcher.base.verb_table import CONTROL_VERBS, module_of
from launcher.cli.dispatch import VERBS
from launcher.launch.verbs.launch import COMMAND as LAUNCH
from tests.docs.unit.test_docs import README
from tests.support.repository import REPOSITORY, docs_page

PAGE = docs_page("own-messages")
EXAMPLE = REPOSITORY / "examples" / "fleet_workspace" / "src"
CREATED = {"my_robot": ("my_robot.launch.py",), "my_robot_interfaces": ()}
PACKAGES = {*CREATED, *(path.name for path in EXAMPLE.iterdir())}
BLOCKS = re.findall(r"^```\w*\n(.*?)^```$", PAGE + README, re.M | re.S)
COMMANDS = {
    command.strip()
    for block in BLOCKS
    for command in re.findall(r"(?:^(?:\$ )?|\$\()launcher ([^\n#)|]*)", block, re.M)
}


@pytest.mark.parametrize("text", sorted(COMMANDS))
def test_a_command_is_accepted(text: str):
    words = shlex.split(text)
    if words[0] in VERBS:
        module = importlib.import_module(module_of(words[0]))
        module.COMMAND.parse(words[1:])
    elif words[0] not in CONTROL_VERBS:
        LAUNCH.parse(words)
    if words[0] in PACKAGES:
        package, file = words
        assert file in CREATED.get(package, ()) or (EXAMPLE / package / "launch" / file).is_file()


def test_there_are_commands_of_every_verb_for_workspaces():
    assert {"build", "env", "pkg", "test", "wheel"} <= {text.split()[0] for text in COMMANDS}


def test_every_interface_that_the_page_names_is_in_the_example():
    named = set(re.findall(r"\bfleet_interfaces/(\w+)/(\w+?)(?:_\w+)?\b", PAGE))
    assert named
    for kind, name in named:
        assert (EXAMPLE / "fleet_interfaces" / kind / f"{name}.{kind}").is_file(), name


def test_every_test_that_the_page_names_exists():
    assert all((REPOSITORY / path).is_file() for path in re.findall(r"`(tests/[\w/.]+)`", PAGE))
