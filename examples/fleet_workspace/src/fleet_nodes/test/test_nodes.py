"""Each node alone, in this process, on DDS."""

from __future__ import annotations

import time

import pytest
import rclpy
from fleet_interfaces.action import ExecuteTask
from fleet_interfaces.msg import RobotStatus, TaskAssignment
from fleet_interfaces.srv import CountTasks
from fleet_nodes.dispatcher import Dispatcher
from fleet_nodes.monitor import Monitor
from fleet_nodes.robot import Robot
from fleet_nodes.runner import WaitingExecutor
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

TIMEOUT_S = 30.0
SPIN_S = 0.02


class Stage:
    """Runs nodes in a separate context: robots by several threads, the others by one.

    As in a run: an action client of rclpy may lose an answer that another thread takes.
    """

    def __init__(self) -> None:
        self.context = Context()
        rclpy.init(context=self.context)
        self.robots = WaitingExecutor(num_threads=3, context=self.context)
        self.others = SingleThreadedExecutor(context=self.context)
        self.tester = self.add(Node("tester", context=self.context))

    def add(self, node: Node) -> Node:
        executor = self.robots if isinstance(node, Robot) else self.others
        executor.add_node(node)
        return node

    def wait_until(self, fact) -> None:
        deadline = time.monotonic() + TIMEOUT_S
        while not fact():
            assert time.monotonic() < deadline
            for executor in (self.robots, self.others):
                executor.spin_once(timeout_sec=SPIN_S)

    def result(self, future):
        self.wait_until(future.done)
        return future.result()

    def close(self) -> None:
        robots, others = self.robots.get_nodes(), self.others.get_nodes()
        for robot in robots:
            self.wait_until(robot.stop)
        self.robots.shutdown()
        self.others.shutdown()
        for node in robots + others:
            node.destroy_node()
        self.context.try_shutdown()


@pytest.fixture
def stage():
    stage = Stage()
    yield stage
    stage.close()


def robot(stage: Stage, duration_s: float) -> Node:
    duration = Parameter("task_duration_s", value=duration_s)
    return stage.add(Robot(context=stage.context, parameter_overrides=[duration]))


def send(stage: Stage, assignment: TaskAssignment, feedback=None):
    client = ActionClient(stage.tester, ExecuteTask, "/robot/execute_task")
    stage.wait_until(client.server_is_ready)
    goal = ExecuteTask.Goal(assignment=assignment)
    return stage.result(client.send_goal_async(goal, feedback_callback=feedback))


def test_a_robot_executes_its_task(stage):
    robot(stage, 0.3)
    statuses, progress = [], []
    stage.tester.create_subscription(RobotStatus, "/fleet/status", statuses.append, 10)

    assignment = TaskAssignment(task_id=7, robot_id="robot")
    goal = send(stage, assignment, lambda message: progress.append(message.feedback.progress))
    took = stage.result(goal.get_result_async()).result.took
    stage.wait_until(lambda: statuses and 7 in statuses[-1].finished)

    assert took.sec + took.nanosec / 1e9 >= 0.3
    assert all(0.0 <= share <= 1.0 for share in progress)
    assert statuses[-1].state == RobotStatus.IDLE
    assert statuses[-1].assignment == assignment


def test_a_robot_rejects_a_task_for_another(stage):
    robot(stage, 0.1)
    assert not send(stage, TaskAssignment(task_id=7, robot_id="robot_9")).accepted


def test_a_robot_rejects_a_task_while_it_is_busy_and_can_be_cancelled(stage):
    robot(stage, 600.0)
    first = send(stage, TaskAssignment(task_id=1, robot_id="robot"))
    assert first.accepted
    assert not send(stage, TaskAssignment(task_id=2, robot_id="robot")).accepted

    stage.result(first.cancel_goal_async())
    stage.result(first.get_result_async())
    assert send(stage, TaskAssignment(task_id=3, robot_id="robot")).accepted


def test_the_monitor_counts_a_task_once(stage):
    stage.add(Monitor(context=stage.context))
    statuses = stage.tester.create_publisher(RobotStatus, "/fleet/status", 10)
    client = stage.tester.create_client(CountTasks, "/monitor/count_tasks")
    stage.wait_until(lambda: statuses.get_subscription_count() and client.service_is_ready())

    def count() -> CountTasks.Response:
        statuses.publish(RobotStatus(robot_id="robot_1", finished=[1, 2]))
        return stage.result(client.call_async(CountTasks.Request(robot_id="robot_1")))

    stage.wait_until(lambda: count().finished == 2)
    assert count() == CountTasks.Response(known=True, finished=2)


def test_the_dispatcher_gives_tasks_to_a_robot(stage):
    robot(stage, 0.1)
    assigned = []
    stage.tester.create_subscription(TaskAssignment, "/fleet/tasks", assigned.append, 10)
    overrides = [Parameter("robot_ids", value=["robot"]), Parameter("period_s", value=0.1)]
    stage.add(Dispatcher(context=stage.context, parameter_overrides=overrides))

    stage.wait_until(lambda: len(assigned) >= 2)
    first, second = assigned[:2]
    assert (second.task_id, second.robot_id) == (first.task_id + 1, "robot")
