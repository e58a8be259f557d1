"""Launch files and parameter files that change while a run watches them."""

from __future__ import annotations

import signal
import sys

import pytest

from tests.support.waiting import wait_until
from tests.support.watching import Desk, pids, wait_for_watching


def test_a_parameter_file(desk: Desk):
    parameters = desk.folder / "p.yaml"
    parameters.write_text("/**: {ros__parameters: {x: 1}}\n")
    node = desk.node("a").replace(
        ', "a"]', f', "a", "--ros-args", "--params-file", "{parameters}"]'
    )
    with desk.run(node) as run:
        wait_for_watching(run, "a")
        before = pids(run)
        parameters.write_text("a: 1\n")
        run.wait_for("p.yaml:1: expected 'ros__parameters:' below 'a'")
        assert pids(run) == before
        parameters.write_text("/**: {ros__parameters: {x: 2}}\n")
        run.wait_for("p.yaml changed: a-1 restarts")
        wait_until(lambda: run.screen.count("a runs 1") == 2, "the restart")


def test_the_launch_file_and_what_it_includes(desk: Desk):
    included = desk.bench.folder / "other.launch.py"
    head = desk.launch_file
    text = """from launch import LaunchDescription
from launch.actions import ExecuteProcess
def generate_launch_description():
    return LaunchDescription([ExecuteProcess(cmd=["sleep", "{}"], name="included")])
"""
    included.write_text(text.format(1000))
    include = f"""__import__("launch").actions.IncludeLaunchDescription("{included}")"""
    with desk.run(f"{desk.node('a')}, {include}") as run:
        wait_for_watching(run, "a")
        wait_until(lambda: len(run.ask("watch")["launch_files"]) == 2, "the launch files")
        before = pids(run)
        included.write_text(text.format(2000))
        run.wait_for("the launch file was reloaded: changed: included-2")
        assert pids(run)["a-1"] == before["a-1"]
        head.write_text(head.read_text() + ")")
        run.wait_for("the launch file was not reloaded: everything runs on")
        assert "bench.launch.py:21: unmatched ')'" in run.screen or ": unmatched ')'" in run.screen
        desk.bench.command(f"{desk.node('a')}, {desk.node('b')}")
        run.wait_for("the launch file was reloaded: new: b-3; gone: included-2")
        assert pids(run)["a-1"] == before["a-1"]
        wait_for_watching(run, "a", "b")
        desk.part.write_text("VALUE = 9\n")
        run.wait_for("b runs 9")


def test_a_restart_that_the_end_of_the_run_prevents_is_told(desk: Desk):
    done = desk.bench.folder / "done"
    slow = f"""sh('trap "echo stopping" INT; echo {{}}; until test -e {done}; do sleep 0.1; done',
        name="slow", output="screen", sigterm_timeout="600")"""
    with desk.run(slow.format("first")) as run:
        run.wait_for("first")
        wait_until(lambda: run.ask("watch")["launch_files"], "the launch file to be watched")
        desk.bench.command(slow.format("second"))
        run.wait_for("stopping")
        run.process.send_signal(signal.SIGINT)
        run.wait_for("user interrupted with ")
        done.touch()
        run.exit_code()
        assert "the launch file was reloaded: not restarted: slow-1" in run.screen


def test_a_file_that_the_launch_file_reads(desk: Desk):
    names = desk.bench.folder / "names.txt"
    names.write_text("one")
    actions = f"""*[sh("exec sleep 1000", name=name) for name in open("{names}").read().split()]"""
    with desk.run(actions) as run:
        wait_until(lambda: str(names) in run.ask("watch")["launch_files"], "the file that is read")
        before = pids(run)
        names.write_text("one two")
        run.wait_for("names.txt changed: the launch file is evaluated again")
        run.wait_for("the launch file was reloaded: new: two-2")
        assert before.items() <= pids(run).items()


LIFECYCLE_NODE = """import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import Node, TransitionCallbackReturn

import part

class Steered(Node):
    def on_configure(self, state):
        print(f"configured {part.VALUE}", flush=True)
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        print(f"activated {part.VALUE}", flush=True)
        return super().on_activate(state)

rclpy.init()
node = Steered("steered")
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""
LIFECYCLE_ACTIONS = """*__import__("steering").actions({!r})"""
STEERING = """from launch.actions import EmitEvent, RegisterEventHandler
from launch.events import matches_action
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState

def actions(script):
    node = LifecycleNode(executable=script, name="steered", namespace="", output="screen")
    def change(number):
        matcher = matches_action(node)
        return EmitEvent(event=ChangeState(lifecycle_node_matcher=matcher, transition_id=number))
    handler = OnStateTransition(
        target_lifecycle_node=node, goal_state="inactive", entities=[change(3)])
    return [node, RegisterEventHandler(handler), change(1)]
"""


@pytest.mark.thorough
def test_a_lifecycle_node_goes_through_its_transitions_again(desk: Desk):
    script = desk.folder / "steered.py"
    script.write_text(f"#!{sys.executable}\n{LIFECYCLE_NODE}")
    script.chmod(0o755)
    (desk.bench.folder / "steering.py").write_text(STEERING)
    path = f"*(sys.path.insert(0, {str(desk.bench.folder)!r}) or ()), "
    with desk.run(path + LIFECYCLE_ACTIONS.format(str(script))) as run:
        run.wait_for("activated 1")
        wait_until(lambda: run.ask("watch")["processes"][0]["files"], "the files")
        assert {one["change"] for one in run.ask("reload")["processes"]} == {"same"}
        desk.part.write_text("VALUE = 2\n")
        run.wait_for("activated 2")
        assert {one["change"] for one in run.ask("reload")["processes"]} == {"same"}
        desk.part.write_text("VALUE = 3\n")
        run.wait_for("activated 3")
        for value in (1, 2):
            assert run.screen.count(f"activated {value}") == 1, "it was asked for again"
