"""Features of published launch files that no other test covers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from launcher.launch.plan.plan import Plan
from launcher.launch.plan.planner import make_plan


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


# Laid out like the real package: what it exports, and what its parts import from one another.
INSTALLED = {
    "__init__.py": (
        "from .ready_to_test_action_timeout import ready_to_test_action_timeout\n"
        "from . import asserts, io_handler, tools, util\n"
    ),
    "ready_to_test_action_timeout.py": (
        "def ready_to_test_action_timeout(timeout):\n    return lambda made: made\n"
    ),
    "util/__init__.py": "from .proc_lookup import LIMIT\n",
    "util/proc_lookup.py": "import launch.actions\nLIMIT = 'seen'\n",
    "asserts/__init__.py": "from ..util import LIMIT\n",
    "io_handler.py": "from .util import LIMIT\n",
    "tools/__init__.py": (
        "import launch.events.process\nfrom launch.utilities import ensure_argument_type\n"
        "from ..io_handler import LIMIT\n"
    ),
    "test_runner.py": (
        "from launch import LaunchService\nfrom launch.event_handlers import OnProcessIO\n"
        "from .io_handler import LIMIT\n"
    ),
    "markers.py": "def keep_alive(made):\n    return made\n",
}

USES_INSTALLED = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess
import launch_testing
import launch_testing.test_runner
import launch_testing.util
from launch_testing.asserts import LIMIT
from launch_testing.markers import keep_alive
from launch_testing.tools import LIMIT as SAME

@launch_testing.ready_to_test_action_timeout(10)
def generate_launch_description():
    return LaunchDescription([ExecuteProcess(cmd=[LIMIT, SAME, launch_testing.util.LIMIT])])
"""


def test_an_installed_launch_testing_is_used_as_a_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    package = tmp_path / "installed" / "launch_testing"
    for name, text in INSTALLED.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(text)
    monkeypatch.syspath_prepend(package.parent)

    assert commands(planned(tmp_path, USES_INSTALLED)) == [["seen", "seen", "seen"]]


def test_a_folder_named_launch_testing_hides_nothing(tmp_path: Path, monkeypatch):
    (tmp_path / "launch_testing").mkdir()
    monkeypatch.syspath_prepend(tmp_path)

    plan = planned(
        tmp_path,
        "import launch_testing\n"
        "from launch import LaunchDescription\n"
        "from launch_testing.actions import ReadyToTest\n"
        "@launch_testing.ready_to_test_action_timeout(3.0)\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([ReadyToTest()])\n",
    )

    assert commands(plan) == []


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
