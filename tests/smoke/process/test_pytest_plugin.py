"""The pytest plugin, in separate pytest runs with real processes."""

from __future__ import annotations

import re
import uuid
from pathlib import Path
from typing import Any

import pytest

from tests.support.drawing import CAN_DRAW
from tests.support.repository import docs_page

pytest_plugins = ["pytester"]

LAUNCH = """
import sys
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

def sh(name, *script):
    return ExecuteProcess(cmd=["sh", "-c", *script], name=name, output="screen")

def py(name, script):
    return ExecuteProcess(cmd=[sys.executable, "-c", script], name=name, output="screen")

def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("word", default_value="nothing"),
        sh("teller", ["echo I was told ", LaunchConfiguration("word"), "; exec sleep 1000"]),
        sh("counter", "i=0; while :; do echo count $i; i=$((i+1)); sleep 0.1; done"),
    ])
"""
TALKER = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=[sys.executable, "talker.py"], name="talker", output="screen"),
    ])
"""
NODE = """
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

class Talker(Node):
    def __init__(self):
        super().__init__("talker")
        self.declare_parameter("speed", 1.0)
        self.said = self.create_publisher(String, "said", 10)
        self.create_subscription(String, "heard", lambda m: self.say(f"heard {m.data}"), 10)
        self.create_service(Trigger, "ask", self.answer)
        self.create_timer(0.1, lambda: self.say("tick"))

    def say(self, text):
        self.said.publish(String(data=text))

    def answer(self, request, response):
        response.message = "here"
        return response

rclpy.init()
talker = Talker()
try:
    rclpy.spin(talker)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
talker.destroy_node()
"""

# A busy machine takes longer than 2 s to refuse a launch file.
LATE_REFUSAL = "import launcher.smoke.pytest_plugin\nlauncher.smoke.pytest_plugin.REFUSAL_S = 60\n"


SMOKE_PAGE = docs_page("smoke")


@pytest.fixture
def folder(pytester: pytest.Pytester) -> pytest.Pytester:
    pytester.makeini("[pytest]\naddopts = -p no:cacheprovider")
    (pytester.path / "two.launch.py").write_text(LAUNCH, encoding="utf-8")
    return pytester


def test_a_system_can_be_awaited_controlled_and_inspected(folder: pytest.Pytester):
    folder.makepyfile(
        """
        import pytest
        from launcher.smoke import NotSeenError

        def test_it(launched_system):
            system = launched_system("two.launch.py", probe=False, word="something")
            assert system.wait_for_log("teller", "I was told").plain == "I was told something"
            system.wait_for_log("counter", "count 3")
            assert system.logs("teller") == ["I was told something"]
            with pytest.raises(NotSeenError, match="count"):
                system.wait_for_log("counter", "never", 0.2)

            system.kill("teller")
            assert system.wait_for_exit("teller").details["returncode"] == -9
            system.start("teller")
            system.wait_for_log("teller", "I was told", count=2)
            system.pause("counter")
            assert system.processes()["counter-2"]["paused"]
            paused_s = system.facts.now_s
            system.resume("counter")
            system.wait_for_log("counter", "count", since_s=paused_s)
            system.stop("counter")
            assert system.processes()["counter-2"]["pid"] is None
            assert system.exit_code is None
            assert system.shutdown().returncode == system.exit_code
            assert system.environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"

        def test_two_at_once_and_one_that_ends_by_itself(launched_system, tmp_path):
            file = tmp_path / "short.launch.py"
            file.write_text(open("two.launch.py").read().replace("exec sleep 1000", "exit 3")
                            .replace("while :; do", "exit 0; while :; do"))
            systems = [launched_system(f, probe=False) for f in (file, "two.launch.py")]
            assert systems[0].wait_for_end() == 1
            systems[1].wait_for_log("counter", "count 1")
            assert systems[0].system.domain_id != systems[1].system.domain_id
        """
    )
    result = folder.runpytest_subprocess("-q")
    result.assert_outcomes(passed=2)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("launch", "told"),
    [
        ('"three.launch.py"', "three.launch.py"),
        ('"two.launch.py", wrod="something"', "did you mean 'word'?"),
    ],
    ids=["no such file", "a misspelt argument"],
)
def test_what_cannot_be_launched_fails_the_test(folder: pytest.Pytester, launch: str, told: str):
    folder.makeconftest(LATE_REFUSAL)
    folder.makepyfile(
        f"def test_it(launched_system):\n    launched_system({launch}, probe=False)\n"
    )
    result = folder.runpytest_subprocess("-q")
    result.assert_outcomes(failed=1)
    assert "nothing was launched" in result.stdout.str()
    assert told in result.stdout.str()


def test_what_ros_knows_is_waited_for_and_asked(folder: pytest.Pytester):
    (folder.path / "talker.py").write_text(NODE, encoding="utf-8")
    (folder.path / "talker.launch.py").write_text(TALKER, encoding="utf-8")
    folder.makepyfile(
        """
        import contextlib
        from launcher.smoke.observe.probe_client import ProbeError

        def test_it(launched_system):
            system = launched_system("talker.launch.py", timeout_s=5)

            # A message or an answer is lost where the other side is not yet discovered.
            def is_so(fact):
                with contextlib.suppress(ProbeError):
                    return fact()

            def is_heard():
                system.publish("/heard", "std_msgs/msg/String", {"data": "hello"})
                return {"data": "heard hello"} in system.messages("/said")

            def is_set():
                system.set_parameter("/talker", "speed", 2)
                return system.parameter("/talker", "speed") == 2.0

            system.wait_for_node("/talker", 60)
            system.wait_for_topic("/said", "std_msgs/msg/String", 60, publishers=1)
            message = system.wait_for_message("/said", lambda m: m["data"] == "tick", 60)
            assert message.topic == "/said"
            system.wait_until(lambda: is_so(is_heard), "it hears and answers", 60)
            assert {"data": "tick"} in system.messages("/said")
            asked = lambda: system.call("/ask")["message"] == "here"
            system.wait_until(lambda: is_so(asked), "the service answers", 60)
            system.wait_until(lambda: is_so(is_set), "the parameter is set", 60)
            assert system.shutdown().returncode == 0
        """
    )
    folder.runpytest_subprocess("-q").assert_outcomes(passed=1)


@pytest.mark.thorough
def test_a_failed_test_shows_the_last_lines_and_keeps_the_evidence(folder: pytest.Pytester):
    folder.makepyfile(
        """
        def test_it(launched_system):
            system = launched_system("two.launch.py", word="secrets")
            system.wait_for_log("teller", "I was told")
            system.kill("teller")
            system.wait_for_exit("teller")
            assert "this" == "that"
        """
    )
    result = folder.runpytest_subprocess("--launch-artifacts", "kept")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        ["*launched system*", "python -m launcher *two.launch.py word:=secrets"]
    )
    result.stdout.fnmatch_lines(["--- teller-1 (ended with -9)", "I was told secrets"])
    kept = {path.name for path in (folder.path / "kept").rglob("*") if path.is_file()}
    assert {"launcher.out", "events.jsonl", "launch.log", "graph.json"} <= kept
    assert ("graph.svg" in kept) == CAN_DRAW


@pytest.mark.thorough
def test_a_misspelt_name_is_reported_with_the_existing_names(folder: pytest.Pytester):
    folder.makepyfile(
        """
        import pytest

        @pytest.mark.parametrize("ask", [
            lambda system: system.kill("tellr"),
            lambda system: system.wait_for_log("counter", "I was told", 0.1),
            lambda system: system.wait_for_exit("tellr", 0.1),
        ])
        def test_it(launched_system, ask):
            system = launched_system("two.launch.py", probe=False)
            system.wait_for_log("teller", "I was told")
            system.wait_for_log("counter", "count")
            ask(system)
        """
    )
    result = folder.runpytest_subprocess("-q")
    result.assert_outcomes(failed=3)
    result.stdout.fnmatch_lines(["*no process 'tellr' is running", "running: teller-1, counter-2"])
    result.stdout.fnmatch_lines(["*maybe: teller-1 printed such a line, at *"])
    result.stdout.fnmatch_lines(["*maybe: no process is named tellr; there are: teller-1, *"])


@pytest.mark.thorough
def test_a_launch_file_that_does_not_load_is_shown(folder: pytest.Pytester):
    folder.makeconftest(LATE_REFUSAL)
    (folder.path / "bad.launch.py").write_text("import nonsense\n", encoding="utf-8")
    folder.makepyfile(
        """
        def test_it(launched_system):
            launched_system("bad.launch.py", probe=False).wait_for_log("*", "never", 60)
        """
    )
    result = folder.runpytest_subprocess("-q")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["the launcher ended with *", "*nonsense*"])


@pytest.mark.thorough
def test_what_is_left_behind_fails_the_test(folder: pytest.Pytester):
    left = Path("/dev/shm") / f"left_{uuid.uuid4().hex}"
    script = (
        f"import mmap, time; f = open('{left}', 'wb+'); f.write(b'x' * 4096); f.flush(); "
        "m = mmap.mmap(f.fileno(), 4096); print('mapped', flush=True); time.sleep(1000)"
    )
    text = LAUNCH.replace('sh("teller"', f'py("holder", {script!r}), sh("teller"')
    (folder.path / "holder.launch.py").write_text(text, encoding="utf-8")
    folder.makepyfile(
        """
        def test_it(launched_system):
            launched_system("holder.launch.py", probe=False).wait_for_log("holder", "mapped")
        """
    )
    try:
        result = folder.runpytest_subprocess("-q")
    finally:
        left.unlink()
    result.assert_outcomes(passed=1, errors=1)
    result.stdout.fnmatch_lines([f"*left behind: {left}"])


@pytest.mark.thorough
def test_a_run_without_launched_systems_imports_nothing_of_them(folder: pytest.Pytester):
    folder.makepyfile(
        """
        import sys

        def test_it():
            heavy = {"rclpy", "yaml", "psutil", "launcher.smoke.run", "launcher.run"}
            assert "launcher.smoke.pytest_plugin" in sys.modules
            assert not heavy & set(sys.modules)
        """
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # others may import what they like
        result = folder.runpytest_subprocess("-q", "-p", "launcher.smoke.pytest_plugin")
    result.assert_outcomes(passed=1)


def test_pytest_finds_the_plugin_by_itself(folder: pytest.Pytester):
    result = folder.runpytest_subprocess("--fixtures")
    result.stdout.fnmatch_lines(["launched_system -- *launcher/smoke/pytest_plugin.py:*"])


@pytest.mark.thorough
def test_the_example_of_the_documentation_passes(launched_system):
    example = re.search(r"```python\n(.*?)```", SMOKE_PAGE, re.DOTALL)
    assert example is not None
    names: dict[str, Any] = {}
    exec(example[1], names)
    names["test_the_monitor_misses_a_stopped_robot"](launched_system)
