"""Features of published launch files that no other test covers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from launcher.planner import Plan, make_plan


def planned(tmp_path: Path, text: str, **arguments: str) -> Plan:
    file = tmp_path / "some.launch.py"
    file.write_text(text)
    plan = make_plan(str(file), list(arguments.items()))
    assert plan.error is None, plan.error
    return plan


def commands(plan: Plan) -> list[Any]:
    return [list(process.spec.argv) for process in plan.processes]


TEST_FILE = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import ExecuteProcess
from launch_testing.legacy import LaunchTestService

def generate_launch_description():
    service = LaunchTestService()
    description = LaunchDescription()
    service.add_fixture_action(description, ExecuteProcess(cmd=["fixture"]), exit_allowed=True)
    for name in ("one", "two"):
        service.add_test_action(description, ExecuteProcess(cmd=[name]))
    return description

def main(argv=sys.argv[1:]):
    return LaunchTestService().run(LaunchService(argv=argv))

if __name__ == "__main__":
    sys.exit(main())
"""


def test_the_last_test_of_a_legacy_test_service_ends_the_system(tmp_path: Path):
    plan = planned(tmp_path, TEST_FILE)

    assert commands(plan) == [["fixture"], ["one"], ["two"]]
    assert [reason for reason, _ in plan.shutdowns] == ["all tests finished"]


def test_a_part_of_launch_testing_that_is_not_here_comes_from_an_installed_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    package = tmp_path / "installed" / "launch_testing"
    package.mkdir(parents=True)
    (package / "__init__.py").touch()
    (package / "asserts.py").write_text("LIMIT = 'seen'\n")
    monkeypatch.syspath_prepend(package.parent)

    plan = planned(
        tmp_path,
        "from launch import LaunchDescription\n"
        "from launch.actions import ExecuteProcess\n"
        "from launch_testing.asserts import LIMIT\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([ExecuteProcess(cmd=[LIMIT])])\n",
    )

    assert commands(plan) == [["seen"]]


def make_package(prefix: Path, name: str, *programs: str) -> None:
    marker = prefix / "share" / "ament_index" / "resource_index" / "packages" / name
    marker.parent.mkdir(parents=True)
    marker.touch()
    for program in programs:
        file = prefix / "lib" / name / program
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch(mode=0o755)


def node_file(program: str) -> str:
    return (
        "from launch import LaunchDescription\n"
        "from launch_ros.actions import Node\n"
        "def generate_launch_description():\n"
        f"    return LaunchDescription([Node(package='tools', executable={program!r})])\n"
    )


def test_a_program_in_a_folder_below_its_package_is_not_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    make_package(tmp_path, "tools", "scripts/run.py")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    file = tmp_path / "some.launch.py"
    file.write_text(node_file("scripts/run.py"))

    plan = make_plan(str(file), [])

    assert plan.error is not None
    assert plan.error.kind == "SubstitutionFailure"
    assert "without a slash" in str(plan.error.fault.hint)


def test_a_program_of_a_package_may_be_given_as_a_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    make_package(tmp_path, "tools", "scripts/run.py")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    program = str(tmp_path / "lib" / "tools" / "scripts" / "run.py")

    plan = planned(tmp_path, node_file(program))

    assert commands(plan) == [[program, "--ros-args"]]
