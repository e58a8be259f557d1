"""What cannot be exported is told, with its name and place."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.base.model.run_options import RunOptions
from launcher.export.export_model import ExportedSystem
from launcher.export.export_settings import ExportSettings, export
from launcher.launch.launch_options import with_settings_beside

Export = Callable[..., ExportedSystem]


def told(system: ExportedSystem) -> list[tuple[str, tuple[str, ...], bool]]:
    return [(gap.what, gap.names, gap.is_note) for gap in system.gaps]


@pytest.mark.parametrize(
    ("actions", "what", "names"),
    [
        ("node('a', on_exit=Shutdown())", "on_exit", ("a",)),
        (
            "n := node('a'), RegisterEventHandler(OnProcessExit(target_action=n, on_exit=[]))",
            "OnProcessExit",
            ("a",),
        ),
        (
            "node('a'), RegisterEventHandler(OnProcessIO(on_stdout=lambda event: None))",
            "OnProcessIO",
            (),
        ),
        ("node('a'), RegisterEventHandler(OnShutdown(on_shutdown=[]))", "OnShutdown", ()),
        ("node('a'), TimerAction(period=9.0, actions=[Shutdown()])", "Shutdown", ()),
        ("node('a', prefix='xterm -e')", "prefix 'xterm'", ("a",)),
        ("node('a'), RosTimer(period=1.0, actions=[])", "RosTimer", ()),
        (
            "ComposableNodeContainer(name='c', namespace='/x', package='group_gp1', "
            "executable='robot_1', composable_node_descriptions=["
            "ComposableNode(package='p', plugin='p::Camera', name='camera')])",
            "ComposableNode camera",
            (),
        ),
    ],
)
def test_it_is_told(exported: Export, actions: str, what: str, names: tuple[str, ...]):
    system = exported(actions)
    assert (what, names, False) in told(system)
    gap = next(gap for gap in system.gaps if gap.what == what)
    assert gap.place.startswith("demo.launch.py:")


def test_lifecycle_transitions_are_told(exported: Export):
    system = exported(
        "LifecycleNode(package='group_gp1', executable='robot_1', name='a', namespace='/'), "
        "LifecycleTransition(lifecycle_node_names=['/a'], transition_ids=[1, 3])"
    )
    assert ("transition 'configure' of /a", (), False) in told(system)


def test_what_starts_after_an_exit_is_left_out_and_told(exported: Export):
    system = exported("node('a', on_exit=[node('late')])")
    assert [one.unit for one in system.processes] == ["a"]
    (gap,) = (gap for gap in system.gaps if "not exported" in gap.text)
    assert "the exit of robot_1" in gap.text


def test_what_starts_after_an_exit_that_the_launch_file_causes_is_left_out(exported: Export):
    stop = "EmitEvent(event=ShutdownProcess(process_matcher=lambda action: True))"
    system = exported(
        f"node('a', on_exit=[node('late')]), TimerAction(period=3.0, actions=[{stop}])",
        before="from launch.events.process import ShutdownProcess\n",
    )
    assert [one.unit for one in system.processes] == ["a"]
    (gap,) = (gap for gap in system.gaps if "not exported" in gap.text)
    assert "the exit of robot_1" in gap.text


def test_functions_that_ran_and_messages_are_notes(exported: Export):
    function = "def later(context):\n    from launch_ros.actions import Node\n    return []\n"
    system = exported(
        "node('a'), OpaqueFunction(function=later), LogInfo(msg='hi')", before=function
    )
    assert told(system) == [("OpaqueFunction later", (), True), ("LogInfo", (), True)]


def test_a_plain_launch_file_has_no_gaps(exported: Export):
    assert exported("node('a'), GroupAction([node('b')])").gaps == ()


def test_what_a_condition_skips_is_not_told(exported: Export):
    before = "from launch.conditions import IfCondition\n"
    system = exported("node('a'), Shutdown(condition=IfCondition('false'))", before=before)
    assert system.gaps == ()


SETTINGS = """
dispatcher: {ready_when: {publisher: /fleet/tasks}, restart: always}
"arm_*":
  after: dispatcher
  restart_with: dispatcher
  memory: 200M
"""


def test_what_a_supervision_file_says_is_exported_or_told(exported: Export, tmp_path: Path):
    path = tmp_path / "demo.supervise.yaml"
    path.write_text(SETTINGS)
    options = with_settings_beside(RunOptions(), str(tmp_path / "demo.launch.py"))
    system = exported("node('dispatcher'), node('arm_1'), node('arm_2')", options=options)
    assert [gap.line for gap in system.gaps] == [
        "demo.supervise.yaml:2: ready_when (dispatcher): nothing looks whether it is ready",
        "demo.supervise.yaml:4: after (arm_1, arm_2): it starts without waiting for dispatcher",
        "demo.supervise.yaml:3: restart_with (arm_1, arm_2): it is not restarted with dispatcher",
        "demo.supervise.yaml:3: budget (arm_1, arm_2): "
        "nothing is done if it needs more than its budget",
    ]
    unit = export("systemd", system, ExportSettings()).files["dispatcher.service"]
    assert "Restart=always" in unit
