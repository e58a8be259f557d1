"""The import names `launch` and `launch_ros`, inside and outside of `vocabulary()`."""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from launcher.language import launch_session
from launcher.language.actions.event_actions import LogInfo
from launcher.language.compat import is_installed, vocabulary


@pytest.fixture(autouse=True)
def no_launch_module(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Each test begins and ends without a module named `launch`."""
    monkeypatch.delitem(sys.modules, "launch", raising=False)
    yield
    sys.modules.pop("launch", None)


@pytest.fixture
def real_launch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """A package named `launch` that was imported before."""
    package = tmp_path / "site" / "launch"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("WHOSE = 'theirs'\n")
    monkeypatch.syspath_prepend(str(package.parent))
    yield importlib.import_module("launch")


def test_inside_vocabulary_launch_names_are_our_classes():
    with vocabulary():
        from launch.actions import LogInfo as imported

        assert imported is LogInfo


def test_outside_there_is_no_launch_package():
    with vocabulary():
        importlib.import_module("launch.actions")

    assert not [name for name in sys.modules if name.partition(".")[0] == "launch"]
    assert not is_installed("launch")


def test_outside_an_import_finds_the_stand_in_behind_all_that_is_installed():
    code = (
        "import launch.actions\n"
        "from launcher.language.actions.event_actions import LogInfo\n"
        "assert launch.actions.LogInfo is LogInfo"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_real_launch_that_was_imported_before_comes_back_untouched(real_launch: ModuleType):
    with vocabulary():
        assert not hasattr(importlib.import_module("launch"), "WHOSE")

    assert importlib.import_module("launch") is real_launch
    assert real_launch.WHOSE == "theirs"


def test_the_folder_launch_of_a_workspace_does_not_get_in_the_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    (tmp_path / "launch").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend("")
    with vocabulary():
        assert importlib.import_module("launch").LaunchDescription is not None


def test_imports_inside_of_functions_work_while_the_vocabulary_is_open():
    def late() -> type:
        from launch_ros.actions import Node

        return Node

    with vocabulary():
        assert late() is late()


def test_nesting_keeps_the_outer_vocabulary_and_session():
    with vocabulary() as outer:
        first = importlib.import_module("launch")
        with vocabulary() as inner:
            assert launch_session.current() is inner
        assert launch_session.current() is outer
        assert importlib.import_module("launch") is first


def test_classes_keep_one_identity_over_several_vocabularies():
    with vocabulary():
        first = importlib.import_module("launch_ros.actions").Node
    with vocabulary():
        second = importlib.import_module("launch_ros.actions").Node

    assert first is second


def test_an_error_inside_still_closes_the_vocabulary():
    finders = list(sys.meta_path)

    with pytest.raises(ZeroDivisionError), vocabulary():
        importlib.import_module("launch")
        raise ZeroDivisionError

    assert sys.meta_path == finders
    assert "launch" not in sys.modules


@pytest.mark.parametrize("heavy", ["rclpy", "rich", "psutil", "asyncio", "yaml", "dataclasses"])
def test_loading_and_visiting_a_plain_file_imports_nothing_heavy(heavy: str, tmp_path: Path):
    file = tmp_path / "plain.launch.py"
    file.write_text(
        "from launch import LaunchDescription\n"
        "from launch.actions import DeclareLaunchArgument, GroupAction, TimerAction\n"
        "from launch.conditions import IfCondition\n"
        "from launch.substitutions import LaunchConfiguration\n"
        "from launch_ros.actions import Node\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([\n"
        "        DeclareLaunchArgument('on', default_value='true'),\n"
        "        GroupAction([Node(executable='x', name='n', output='screen')],\n"
        "                    condition=IfCondition(LaunchConfiguration('on'))),\n"
        "        TimerAction(period=5.0, actions=[Node(executable='y')])])\n"
    )
    program = (
        "import sys\n"
        "from launcher.language import frontends\n"
        "from launcher.language.interpreter import Interpreter\n"
        "from launcher.language.compat import vocabulary\n"
        "with vocabulary():\n"
        f"    description = frontends.load({str(file)!r})\n"
        "    interpreter = Interpreter(description)\n"
        "    assert len(interpreter.start()) == 2\n"
        "    interpreter.close()\n"
        f"print({heavy!r} in sys.modules)\n"
    )

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)

    assert done.stdout == "False\n", done.stderr


def test_launch_files_find_the_words_of_ros2_launch_in_sys_argv(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "argv", ["launcher", "plan", "--json", "file"])

    with vocabulary(["file.launch.py", "robot:=r2"]):
        assert sys.argv == ["ros2", "launch", "file.launch.py", "robot:=r2"]

    assert sys.argv == ["launcher", "plan", "--json", "file"]
