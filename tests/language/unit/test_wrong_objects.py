"""Arguments that lack what an action calls are mistakes of the launch file."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.base.errors import ExitCode
from launcher.language.compat import vocabulary
from launcher.launch.plan.planner import make_plan
from tests.language.unit.test_errors import HEAD, planned

SWEPT = {  # how an instance of a class of this module gets into a launch file
    "launch.actions": "{}",
    "launch.conditions": "LogInfo(msg='x', condition={})",
    "launch.event_handlers": "RegisterEventHandler({})",
    "launch.substitutions": "LogInfo(msg={})",
    "launch_ros.actions": "{}",
}
FITTING = {
    "cmd": "['true']",
    "event": "Shutdown()",
    "event_handler": "OnShutdown(on_shutdown=[])",
    "function": "print",
    "launch_description_source": "'x.launch.py'",
    "level": "'INFO'",
    "period": "1.0",
}
UNFITTING = ("None", "'x'", "3", "['x']", "LaunchConfiguration('y')")


def calls_with(value: str, module: str) -> Iterator[str]:
    """Calls of each class of the module, in which one argument after the other has the value."""
    with vocabulary():
        found = importlib.import_module(module)
        every = [getattr(found, name) for name in found.__all__]
    classes = [one for one in every if isinstance(one, type) and not issubclass(one, Exception)]
    for cls in classes:
        parameters = inspect.signature(cls).parameters.values()
        named = [one for one in parameters if one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)]
        if any(one.kind is one.VAR_POSITIONAL for one in parameters):
            yield f"{cls.__name__}({value})"
        for swept in [one.name for one in named] + ["condition"] * module.endswith("actions"):
            needed = [one.name for one in named if one.default is one.empty and one.name != swept]
            given = {name: FITTING.get(name, "'x'") for name in needed} | {swept: value}
            yield f"{cls.__name__}({', '.join(map('='.join, given.items()))})"


@pytest.mark.parametrize(
    "value", [UNFITTING[0], *(pytest.param(v, marks=pytest.mark.thorough) for v in UNFITTING[1:])]
)
@pytest.mark.parametrize("module", SWEPT)
def test_no_argument_of_a_public_class_makes_a_fault_of_the_launcher(module, value, tmp_path: Path):
    head = "import warnings\nwarnings.simplefilter('ignore')\nfrom launch.conditions import *\n"
    head += "from launch.event_handlers import *\nfrom launch_ros.actions import *\n" + HEAD
    for number, call in enumerate(calls_with(value, module)):
        file = tmp_path / f"{number}.launch.py"
        entry = SWEPT[module].format(call)
        file.write_text(f"{head}    x = {entry}\n    return LaunchDescription([x])\n")

        error = make_plan(str(file), []).error

        text = "" if error is None else error.fault.render()
        assert "fault of the launcher" not in text, f"{entry}\n{text}"


WRONG_OBJECTS = {
    "LogInfo(msg='x', condition=LaunchConfiguration('m'))": (
        "condition takes a condition, not a LaunchConfiguration",
        "write IfCondition(LaunchConfiguration('m'))",
    ),
    "LogInfo(msg='x', condition=True)": (
        "condition takes a condition, not a bool",
        "write IfCondition('true')",
    ),
    "LogInfo(msg='x', condition=LaunchConfiguration('m') == 'sim')": (
        "condition takes a condition, not a bool",
        "write IfCondition(EqualsSubstitution(LaunchConfiguration('m'), 'sim'))",
    ),
    "RegisterEventHandler(None)": (
        "RegisterEventHandler takes an event handler, not None",
        "write RegisterEventHandler(OnProcessExit(target_action=..., on_exit=[...]))",
    ),
    "RegisterEventHandler(LogInfo(msg='x'))": (
        "RegisterEventHandler takes an event handler, not a LogInfo",
        "write RegisterEventHandler(OnProcessExit(target_action=..., on_exit=[...]))",
    ),
    "ReplaceEnvironmentVariables(environment='x')": (
        "environment takes a dictionary, not a text",
        "write environment={'NAME': 'VALUE'}",
    ),
}


@pytest.mark.parametrize("entry", WRONG_OBJECTS)
def test_an_argument_without_what_is_called_is_a_mistake_of_the_launch_file(entry, tmp_path: Path):
    error = planned(tmp_path, f"    return LaunchDescription([\n        {entry}])\n").error

    assert error is not None
    assert (error.fault.message, error.fault.hint) == WRONG_OBJECTS[entry]
    assert str(error.fault.where).endswith("broken.launch.py:8")
    assert error.fault.exit_code is ExitCode.USAGE
