"""A watched run whose link to a host is lost, and comes back."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tests.support.hosts import Lab
from tests.support.hosts.run import Run
from tests.support.waiting import wait_until

NUMBERS = """\
import sys
import rclpy
from std_msgs.msg import Int64

rclpy.init()
node = rclpy.create_node("numbers")
publisher = node.create_publisher(Int64, "/numbers", 10)
count = 0


def publish():
    global count
    count += publisher.get_subscription_count()
    publisher.publish(Int64())
    print("heard", count, flush=True)


node.create_timer(float(sys.argv[1]), publish)
rclpy.spin(node)
"""
EXPECTED = "expect:\n  - {gap: /numbers, below: 1 s}\n"
LINK, GAP = "reachable: bot", "gap /numbers"


def test_a_lost_link_explains_the_silence_of_its_host_until_it_is_back(lab: Lab, tmp_path: Path):
    bot = lab.host("bot")
    file = tmp_path / "expected.yaml"
    file.write_text(EXPECTED)
    hosts = {bot: {"on_link_loss": "keep"}}
    words = ("--expect", str(file))
    with Run(
        lab, tmp_path, hosts, {"numbers": "bot"}, code=NUMBERS, pause="0.1", words=words
    ) as run:
        faults: dict[str, dict[str, Any]] = {}

        def are(state: str) -> bool:
            done = lab.operator.launcher("faults", "--json")
            found = json.loads(done.stdout)["faults"]
            faults.update({one["fault"]: one for one in found})
            return all(faults.get(name, {}).get("state") == state for name in (LINK, GAP))

        run.wait_for("heard 10$")  # the watcher has had messages
        assert not json.loads(lab.operator.launcher("faults", "--json").stdout)["faults"]
        bot.link_down()
        wait_until(lambda: are("active") and faults[GAP]["follows"] == LINK, "both faults")
        assert faults[LINK]["rule"] == faults[GAP]["rule"] == "lost link"
        assert faults[LINK]["incident"] == faults[GAP]["incident"]
        bot.link_up()
        wait_until(lambda: are("healed"), "the link is back")
        run.stop()
