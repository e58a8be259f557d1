"""The installed command `launcher`: which Python it starts, and with which libraries."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.support.repository import REPOSITORY

SCRIPT = REPOSITORY / "launcher/cli/script/launcher"
HOOK = "ros_wheels_bootstrapper.pth"
DONE = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"
# In place of Python: the words that it gets, and its environment.
PYTHON = '#!/bin/sh\necho "$0"\nfor word; do echo "$word"; done\necho --\nexec env\n'


@dataclass(frozen=True, slots=True)
class Started:
    words: list[str]
    variables: dict[str, str]


class Prefix:
    """An environment with the script, and with wheels of ROS 2 if it has libraries."""

    def __init__(self, folder: Path, *libraries: str, version: str = "python3.12") -> None:
        self.folder = folder
        self.bin = folder / "bin"
        self.site = folder / f"lib/{version}/site-packages"
        self.bin.mkdir(parents=True)
        self.site.mkdir(parents=True)
        shutil.copy(SCRIPT, self.bin)
        self.add_python("python3")
        for name in libraries:
            (self.site / name).mkdir()
        if libraries:
            (self.site / HOOK).touch()

    def add_python(self, name: str) -> None:
        (self.bin / name).write_text(PYTHON)
        (self.bin / name).chmod(0o755)

    def installed_for(self, python: str) -> None:
        """As pip writes the script of `launch_test`."""
        (self.bin / "launch_test").write_text(f"#!{python}\nimport sys\n")

    @property
    def libraries(self) -> list[str]:
        return [str(self.folder / "lib"), *map(str, sorted(self.site.glob("ros_*.libs")))]


def start(*command: str | Path, cwd: Path | None = None, **variables: str) -> Started:
    env = {"PATH": os.environ["PATH"], "PWD": str(cwd or os.getcwd()), **variables}
    done = subprocess.run(
        [*map(str, command), "a b", ""],
        cwd=cwd,
        env=env,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert done.stderr == ""
    words, _, lines = done.stdout.partition("\n--\n")
    found = dict(line.split("=", 1) for line in lines.splitlines())
    return Started(words.split("\n"), found)


@pytest.fixture
def prefix(tmp_path: Path) -> Prefix:
    return Prefix(tmp_path / "an env", "ros_rclpy.libs", "ros_rcl.libs")


def test_it_starts_the_python_beside_it_with_the_libraries_of_the_wheels(prefix: Prefix):
    found = start(prefix.bin / "launcher")
    assert found.words == [f"{prefix.bin}/python3", f"{prefix.bin}/launcher", "a b", ""]
    assert found.variables[DONE] == "1"
    assert found.variables["LD_LIBRARY_PATH"].split(":") == prefix.libraries


@pytest.mark.parametrize(
    ("folder", "words"),
    [
        ("an env", ["bin/launcher"]),
        ("an env/bin", ["./launcher"]),
        ("an env/lib", ["../bin/launcher"]),
        ("an env/bin", ["sh", "launcher"]),
        ("elsewhere", ["./launcher"]),
        ("elsewhere", ["./link-to-link"]),
    ],
    ids=" ".join,
)
def test_it_may_be_started_by_a_relative_path_and_through_links(
    prefix: Prefix, tmp_path: Path, folder: str, words: list[str]
):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere/launcher").symlink_to(prefix.bin / "launcher")
    (tmp_path / "elsewhere/link-to-link").symlink_to("launcher")
    found = start(*words, cwd=tmp_path / folder, CDPATH=str(REPOSITORY))
    assert found.words[:2] == [f"{prefix.bin}/python3", words[-1]]
    assert found.variables["LD_LIBRARY_PATH"].split(":") == prefix.libraries


def test_it_starts_the_python_for_which_pip_has_installed_it(prefix: Prefix, tmp_path: Path):
    system = Prefix(tmp_path / "usr", "ros_rclpy.libs")
    system.add_python("python3.12")
    prefix.installed_for(f"{system.bin}/python3.12")
    found = start(prefix.bin / "launcher")
    assert found.words[0] == f"{system.bin}/python3.12"
    assert found.variables["LD_LIBRARY_PATH"].split(":") == system.libraries


@pytest.mark.parametrize("python", ["/nowhere/bin/python3", "/bin/sh"])
def test_it_starts_the_python_beside_it_if_that_script_leads_to_none(prefix: Prefix, python: str):
    prefix.installed_for(python)  # the environment was moved; its path is long or has spaces
    assert start(prefix.bin / "launcher").words[0] == f"{prefix.bin}/python3"


def test_libraries_of_the_user_come_first(prefix: Prefix):
    mine = f"/opt/mine:/opt/*::{prefix.libraries[1]}:"
    found = start(prefix.bin / "launcher", LD_LIBRARY_PATH=mine)
    first = ["/opt/mine", "/opt/*", prefix.libraries[1]]
    rest = [path for path in prefix.libraries if path not in first]
    assert found.variables["LD_LIBRARY_PATH"].split(":") == [*first, *rest]


def test_nothing_else_of_the_environment_changes(prefix: Prefix):
    given = dict.fromkeys(("bin", "file", "found", "python", "folder", "HOME", "rest"), "x")
    found = start(prefix.bin / "launcher", **given)
    by_shell = {"PATH", "PWD", "OLDPWD", "SHLVL", "_"}
    assert found.variables.keys() - by_shell == {*given, "LD_LIBRARY_PATH", DONE}
    assert given.items() <= found.variables.items()


@pytest.mark.parametrize("libraries", [["ros_rclpy.libs"], []], ids=["wheels", "no wheels"])
def test_options_of_the_shell_that_are_exported_do_not_apply(tmp_path: Path, libraries: list[str]):
    prefix = Prefix(tmp_path / "env", *libraries)
    found = start("bash", prefix.bin / "launcher", SHELLOPTS="errexit:noglob:nounset")
    assert found.words[0] == f"{prefix.bin}/python3"
    assert (DONE in found.variables) is bool(libraries)


@pytest.mark.parametrize(
    ("setting", "libraries"),
    [({DONE: "1", "LD_LIBRARY_PATH": "/a"}, ["ros_rclpy.libs"]), ({"LD_LIBRARY_PATH": "/a"}, [])],
    ids=["the hook has run", "no wheels"],
)
def test_libraries_stay_as_they_are(tmp_path: Path, setting: dict[str, str], libraries: list[str]):
    prefix = Prefix(tmp_path / "env", *libraries)
    found = start(prefix.bin / "launcher", **setting)
    assert {name: found.variables.get(name) for name in (DONE, "LD_LIBRARY_PATH")} == {
        DONE: setting.get(DONE),
        "LD_LIBRARY_PATH": "/a",
    }


def test_wheels_for_several_pythons_are_left_to_the_hook(prefix: Prefix):
    other = prefix.folder / "lib/python3.13/site-packages"
    other.mkdir(parents=True)
    (other / HOOK).touch()
    assert DONE not in start(prefix.bin / "launcher").variables


# What a process of a run has, what the hook would give it, and the name of its parent.
CODE = """
import json, os, ros_wheels_bootstrapper as hook
values = os.environ["LD_LIBRARY_PATH"], hook.get_ros_paths()
with open(f"/proc/{os.getppid()}/comm") as name, open("found.json", "w") as file:
    json.dump([*(value.split(":") for value in values), name.read()], file)
"""
LAUNCH_FILE = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    return LaunchDescription([ExecuteProcess(cmd=%r)])
"""


def test_one_interpreter_starts_and_processes_get_what_the_hook_gives(tmp_path: Path):
    env = {name: value for name, value in os.environ.items() if name != DONE}
    env.update(PYTHONPATH=str(REPOSITORY), PYTHONPROFILEIMPORTTIME="1", LD_LIBRARY_PATH="/mine")
    file = tmp_path / "one.launch.py"
    file.write_text(LAUNCH_FILE % [sys.executable, "-c", CODE])
    shutil.copy(SCRIPT, tmp_path / "launcher")
    (tmp_path / "launch_test").write_text(f"#!{sys.executable}\n")
    done = subprocess.run(
        [tmp_path / "launcher", file, "--no-log-files"],
        cwd=tmp_path,
        env=env,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    # Python's headline; that of the process has its name in front.
    heads = [line for line in done.stderr.splitlines() if line.startswith("import time: self")]
    assert len(heads) == 1, "a Python was started that only starts another one"
    ours, of_hook, name = json.loads((tmp_path / "found.json").read_text())
    assert set(ours) == set(of_hook)
    assert (ours[0], name) == ("/mine", "launcher\n")
