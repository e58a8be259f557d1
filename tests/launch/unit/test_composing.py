"""Which nodes --compose puts into one process, and why others are not."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from typing import Any

import pytest

from launcher.base.errors import UsageError
from launcher.base.model.record import replace
from launcher.base.model.run_options import RunOptions
from launcher.base.model.spec import (
    Limits,
    OutputPolicy,
    ProcessSpec,
    RestartMode,
    RestartPolicy,
    RosIdentity,
    StopPolicy,
)
from launcher.base.model.supervision import StartRule
from launcher.launch.composing import composition
from launcher.launch.launch_options import run_options
from launcher.launch.verbs import launch, plan


@pytest.fixture
def script(tmp_path: Path) -> str:
    path = tmp_path / "node.py"
    path.write_text("import rclpy\n")
    return str(path)


def node(script: str, number: int, *words: str, **changes: Any) -> tuple[int, ProcessSpec]:
    label = f"robot_{number}"
    spec = ProcessSpec(
        name=f"{label}-{number}",
        label=label,
        argv=(sys.executable, script, *words),
        env={"A": "1", "PATH": "/usr/bin"},
        ros=RosIdentity(node_name=label),
    )
    return number, replace(spec, **changes)


def test_nodes_with_the_same_settings_become_one_process(script):
    starts = [node(script, 1), node(script, 2, "--ros-args", "-p", "a:=2"), node(script, 3)]
    found = composition(starts, RunOptions(compose=("robot_[12]",)))
    ((group, members),) = found.groups
    assert members == (1, 2)
    assert (group.name, group.label, group.ros) == ("composed-1", "composed", None)
    assert group.argv == (
        *(sys.executable, "-m", "launcher.ros.composed"),
        *("robot_1-1", "2", sys.executable, script),
        *("robot_2-2", "5", sys.executable, script, "--ros-args", "-p", "a:=2"),
    )
    assert [one.name for one in group.members] == ["robot_1-1", "robot_2-2"]
    assert found.remarks == ("composed-1 is one process for 2 nodes: robot_1-1, robot_2-2",)
    assert group.command_line.endswith("launcher.ros.composed ... (2 nodes)")


def test_each_pattern_has_a_group_of_its_own_and_a_node_is_in_one(script):
    starts = [node(script, number) for number in range(1, 6)]
    found = composition(starts, RunOptions(compose=("robot_[123]", "robot_*")))
    assert [members for _, members in found.groups] == [(1, 2, 3), (4, 5)]
    assert [spec.name for spec, _ in found.groups] == ["composed-1", "composed-2"]


def test_the_name_of_a_group_is_not_that_of_another_process(script):
    taken = node(script, 9, name="composed-1")
    starts = [taken, *(node(script, number) for number in range(1, 5))]
    found = composition(starts, RunOptions(compose=("robot_[12]", "robot_[34]")))
    assert [spec.name for spec, _ in found.groups] == ["composed-2", "composed-3"]


def test_a_node_whose_end_ends_all_is_essential(script):
    always = RestartPolicy(mode=RestartMode.ALWAYS)
    starts = [node(script, 1), node(script, 2)]
    options = RunOptions(compose=("*",), required=("robot_2",))
    ((group, _),) = composition(starts, options).groups
    assert [one.is_essential for one in group.members] == [False, True]
    assert "--essential robot_2-2 2" in " ".join(group.argv)
    starts = [node(script, 1, restart=always), node(script, 2, restart=always)]
    ((group, _),) = composition(starts, RunOptions(compose=("*",))).groups
    assert group.restart == always
    assert all(one.is_essential for one in group.members)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"env": {"A": "2", "PATH": "/usr/bin", "B": ""}}, "environment (A, B)"),
        ({"cwd": "/"}, "working directory"),
        ({"output": OutputPolicy.named("screen")}, "output"),
        ({"emulate_tty": True}, "terminal"),
        ({"restart": RestartPolicy(mode=RestartMode.ALWAYS)}, "restart policy"),
        ({"stop": StopPolicy(polite=((signal.SIGTERM, 1.0),))}, "stop policy"),
        ({"limits": Limits(nice=5)}, "limits"),
    ],
)
def test_other_settings_keep_a_node_apart(script, changes, why):
    starts = [node(script, 1, **changes), node(script, 2), node(script, 3)]
    found = composition(starts, RunOptions(compose=("robot_*",)))
    assert [members for _, members in found.groups] == [(2, 3)]
    assert f"robot_1-1 is not composed: its {why} is not that of robot_2-2" in found.remarks


def test_alike_ones_among_the_others_are_a_group_as_well(script):
    starts = [node(script, number, cwd="/" if number % 2 else None) for number in range(1, 5)]
    found = composition(starts, RunOptions(compose=("*",)))
    assert [members for _, members in found.groups] == [(1, 3), (2, 4)]


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"ros": None}, "it is not started as a ROS node"),
        ({"shell": True}, "it is started by a shell"),
        ({"argv": ("/bin/sleep", "1")}, "'sleep' is not a Python script"),
        ({"argv": ("gdb", "--args", "x")}, "gdb"),
    ],
)
def test_what_is_no_python_node_is_kept_apart(script, changes, why):
    starts = [node(script, 1), node(script, 2), node(script, 3, **changes)]
    found = composition(starts, RunOptions(compose=("*",)))
    assert [members for _, members in found.groups] == [(1, 2)]
    (remark,) = [text for text in found.remarks if text.startswith("robot_3-3 is not composed: ")]
    assert why in remark


def test_settings_of_a_whole_process_keep_a_node_apart(script):
    enclave = node(script, 3, "--ros-args", "--enclave", "/x")
    found = composition([node(script, 1), node(script, 2), enclave], RunOptions(compose=("*",)))
    assert "robot_3-3 is not composed: '--enclave' is a setting of a process" in found.remarks


def test_a_program_that_forks_is_kept_apart(script, tmp_path):
    other = tmp_path / "forks.py"
    other.write_text("def main():\n    from multiprocessing import Pool\n")
    starts = [node(script, 1), node(script, 2), node(str(other), 3)]
    found = composition(starts, RunOptions(compose=("*",)))
    assert [members for _, members in found.groups] == [(1, 2)]
    assert "robot_3-3 is not composed: it imports multiprocessing" in "\n".join(found.remarks)


def test_a_node_whose_output_a_handler_reads_is_kept_apart(script):
    starts = [node(script, number) for number in (1, 2, 3)]
    found = composition(starts, RunOptions(compose=("*",)), lambda number: number == 2)
    assert [members for _, members in found.groups] == [(1, 3)]
    assert "robot_2-2 is not composed: an event handler reads its output" in found.remarks


def test_one_node_alone_is_not_composed(script):
    found = composition([node(script, 1)], RunOptions(compose=("robot_*",)))
    assert found.groups == ()
    reason = "there is no other that 'robot_*' could put with it"
    assert found.remarks == (f"robot_1-1 is not composed: {reason}",)


def test_compose_excludes_other_hosts():
    parsed = launch.COMMAND.parse(["a.launch.py", "--compose", "x", "--hosts", "h.yaml"])
    with pytest.raises(UsageError, match="--compose and --hosts exclude each other"):
        run_options(parsed)


def test_a_plan_refuses_what_a_run_refuses():
    with pytest.raises(UsageError, match="--compose and --hosts exclude each other"):
        plan.main(["a.launch.py", "--compose", "x", "--hosts", "h.yaml"])
    with pytest.raises(UsageError, match="no-such-program"):
        plan.main(["a.launch.py", "--prefix", "x=no-such-program"])


@pytest.mark.parametrize(
    "words",
    [
        *(("--hosts", "h.yaml"), ("--skip-host", "h"), ("--prefix", "x=true"), ("--no-supervise",)),
        *(("--log-level", "x=debug"), ("--compose", "x"), ("--supervise=f.yaml",)),
    ],
)
def test_a_difference_takes_no_options_of_a_run(words, tmp_path):
    (tmp_path / "f.yaml").write_text("{}")
    words = [word.replace("f.yaml", str(tmp_path / "f.yaml")) for word in words]
    with pytest.raises(UsageError, match=f"--diff takes no {words[0].partition('=')[0]}"):
        plan.main(["--diff", *words])


def test_a_node_with_rules_of_its_start_is_kept_apart(script):
    rules = (StartRule(pattern="robot_3", restart_with=("robot_1",)),)
    starts = [node(script, number) for number in (1, 2, 3)]
    found = composition(starts, RunOptions(compose=("*",), start_rules=rules))
    assert [members for _, members in found.groups] == [(1, 2)]
    assert "robot_3-3 is not composed: the supervision file has rules for it" in found.remarks
