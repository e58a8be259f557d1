"""Messages of real nodes that are dropped and late, through the proxy."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

from launcher.control.client import RefusedError
from launcher.posix.domain_lease import leased_domain
from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun
from tests.support.waiting import wait_until

pytest.importorskip("rclpy")

TALKER = """
import itertools, rclpy, time
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("talker")
publisher, numbers = node.create_publisher(String, "chatter", 10), itertools.count()
send = lambda: publisher.publish(String(data=f"{next(numbers)} {time.time()}"))
node.create_timer(0.05, send)
try:
    rclpy.spin(node)
except BaseException:
    pass
"""
LISTENER = """
import rclpy, time
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("listener")
def heard(message):
    number, sent = message.data.split()
    print("heard", number, f"{time.time() - float(sent):.3f}")
node.create_subscription(String, "/news", heard, 10)
try:
    rclpy.spin(node)
except BaseException:
    pass
"""


@pytest.fixture
def bench(control_bench: ControlBench) -> Iterator[ControlBench]:
    with leased_domain() as domain_id:
        control_bench.env["ROS_DOMAIN_ID"] = str(domain_id)
        yield control_bench


def node(bench: ControlBench, name: str, text: str, more: str = "") -> str:
    file = bench.folder / f"{name}.py"
    file.write_text(text)
    return (
        "__import__('launch_ros').actions.Node(executable=sys.executable, output='screen', "
        f"exec_name={name!r}, arguments=[{str(file)!r}]{more}),"
    )


def heard(run: ControlledRun, since: int) -> list[tuple[int, float]]:
    """(number, delay in seconds) of what was heard behind this place of the screen."""
    lines = re.findall(r"heard (\d+) ([\d.]+)", run.screen[since:])
    return [(int(number), float(delay)) for number, delay in lines]


def next_ones(run: ControlledRun, count: int = 8) -> list[tuple[int, float]]:
    """Messages from now on, of one life of the talker."""
    since = len(run.screen)
    wait_until(lambda: len(heard(run, since)) >= count, "messages")
    return heard(run, since)[1:count]


@pytest.mark.thorough
def test_messages_are_dropped_and_late_until_the_end(bench: ControlBench):
    renamed = ", remappings=[('chatter', '/news')], namespace='ns'"
    actions = node(bench, "talker", TALKER, renamed) + node(bench, "listener", LISTENER)
    with bench.launch(actions) as run:
        run.wait_for("heard")
        with pytest.raises(RefusedError, match="it publishes /news; did you mean '/news'"):
            run.ask("inject", "talker", what="drop /new")
        run.ask("inject", "talker", what="drop /news 50", for_s=1000.0)
        assert {number % 2 for number, _ in next_ones(run)} in ({0}, {1})
        with pytest.raises(RefusedError, match="drop /news 50 is active"):
            run.ask("inject", "talker", what="delay /news 100")
        run.ask("inject", "talker", end=True)
        assert {number % 2 for number, _ in next_ones(run)} == {0, 1}
        run.ask("inject", "talker", what="delay /news 300", for_s=1000.0)
        assert min(delay for _, delay in next_ones(run)) >= 0.29  # clocks of two processes
        (info,) = run.ask("info", "talker")["processes"]
        assert "/news:=/news/_injected" in info["cmd"]
        run.ask("quit")
        assert run.exit_code() == 0, run.screen
    assert bench.survivors() == []
