"""Draw the running fleet's graph: `make picture` writes docs/assets/fleet.svg.

Starts the whole system in a separate domain, waits until every node is in the graph, draws the
graph, and stops the system.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

from launcher.posix.domain_lease import leased_domain
from launcher.ros.discovery.observer import Observer
from launcher.ros.draw.dot import to_dot, to_svg
from launcher.ros.snapshot.ros_graph import DEBUG_TOPICS, Endpoint, TopicGraph

NODES = 7
ENDS = 12  # endpoints of the fleet's topics
TOPICS = {"/fleet/tasks", "/fleet/status", "/fleet/report"}
ARGUMENTS = ["enable_debug:=true", "enable_qos_probe:=true"]


def main(target: str) -> int:
    """Write the picture to `target`; 1 if the fleet did not start."""
    with leased_domain() as domain_id:
        os.environ["ROS_DOMAIN_ID"] = str(domain_id)
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        return _run_and_draw(Path(target))


def _run_and_draw(target: Path) -> int:
    fleet = subprocess.Popen(
        [sys.executable, "-m", "launcher", "system", *ARGUMENTS],
        stdout=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        return _draw(target)
    finally:
        fleet.send_signal(signal.SIGINT)
        fleet.wait()


def _draw(target: Path) -> int:
    with Observer() as observer:
        snapshot = observer.wait_for(
            lambda s: len(s.nodes) == NODES and set(s.topics()) >= TOPICS and len(_ends(s)) == ENDS,
            deadline_s=30.0,
        )
    if len(snapshot.nodes) != NODES:
        print(f"error: only these nodes started: {', '.join(snapshot.nodes)}", file=sys.stderr)
        return 1
    target.write_text(to_svg(to_dot(snapshot.without(DEBUG_TOPICS))), encoding="utf-8")
    print(f"wrote {target}: {len(snapshot.nodes)} nodes, {len(_ends(snapshot))} endpoints")
    return 0


def _ends(snapshot: TopicGraph) -> list[Endpoint]:
    return [endpoint for endpoint in snapshot.endpoints if endpoint.topic in TOPICS]


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
