"""Nodes that tests of launch_testing_ros use, and the domain of such a test."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

TEST = """
import os, sys, unittest
import launch, launch_testing, launch_testing.actions, launch_testing_ros, pytest
import rclpy
from launch.actions import ExecuteProcess
from launch_testing_ros import DataRepublisher, MessagePump, WaitForTopics
from launch_testing_ros.actions import EnableRmwIsolation
from std_msgs.msg import String

TALKER = '''
import rclpy
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("talker")
publisher = node.create_publisher(String, "chatter", 10)
node.create_timer(0.05, lambda: publisher.publish(String(data="hello")))
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
'''

@pytest.mark.rostest
def generate_test_description():
    print_domain = ExecuteProcess(cmd=["sh", "-c", "echo domain $ROS_DOMAIN_ID"], name="shell")
    return launch.LaunchDescription([
        EnableRmwIsolation(),
        print_domain,
        ExecuteProcess(cmd=[sys.executable, "-c", TALKER]),
        launch_testing.actions.ReadyToTest(),
    ])

class TestTalker(unittest.TestCase):
    def test_messages(self, proc_output):
        proc_output.assertWaitFor("domain " + os.environ["ROS_DOMAIN_ID"], stream="stdout",
                                  timeout=60)
        assert os.environ["ROS_DOMAIN_ID"] != os.environ["OUTER_DOMAIN"]
        with WaitForTopics([("chatter", String)], timeout=60.0) as waiting:
            assert waiting.topics_received() == {"chatter"}
            assert waiting.topics_not_received() == set()
            assert waiting.received_messages("chatter")[0].data == "hello"

    def test_missing(self):
        asked = []
        waiting = WaitForTopics([("nothing", String)], timeout=0.1,
                                trigger=lambda node, word: asked.append(word))
        assert not waiting.wait("word") and asked == ["word"]
        assert waiting.topics_not_received() == {"nothing"}
        waiting.shutdown()

    def test_passed_on(self):
        rclpy.init()
        node = rclpy.create_node("between")
        changed = lambda message: String(data=message.data.upper())
        between = DataRepublisher(node, "chatter", "loud", String, changed)
        pump = MessagePump(node)
        pump.start()
        with WaitForTopics([("loud", String)], timeout=60.0) as waiting:
            assert waiting.received_messages("loud")[0].data == "HELLO"
        pump.stop()
        assert between.get_num_received() >= between.get_num_republished() > 0
        between.shutdown()
        rclpy.shutdown()
"""


@pytest.mark.thorough
def test_topics_are_waited_for_in_a_domain_of_the_test(env: dict[str, str], tmp_path: Path):
    (tmp_path / "test_it.py").write_text(TEST)
    result = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "."],
        cwd=tmp_path,
        env={**os.environ, **env, "OUTER_DOMAIN": env["ROS_DOMAIN_ID"]},
        text=True,
        capture_output=True,
        timeout=300,
    )

    assert "1 passed" in result.stdout, result.stdout
