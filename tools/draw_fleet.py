"""Draw the running fleet's graph: `make picture` writes docs/fleet.svg.

Starts the whole system in a domain of its own, waits until every node is in the graph, draws
what the graph says (not what we think it is), and stops it.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

DOMAIN = "77"
NODES = 7
ENDS = 12  # of the fleet's own topics
TOPICS = {"/fleet/tasks", "/fleet/status", "/fleet/report"}
ARGUMENTS = ["enable_debug:=true", "enable_qos_probe:=true"]


def main(target: str) -> int:
    """Write the picture to `target`; 1 if the fleet did not come up."""
    os.environ |= {"ROS_DOMAIN_ID": DOMAIN, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    fleet = subprocess.Popen(
        [sys.executable, "-m", "launcher", "system", *ARGUMENTS],
        stdout=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        return _draw(Path(target))
    finally:
        fleet.send_signal(signal.SIGINT)
        fleet.wait()


def _draw(target: Path) -> int:
    from launcher.graph.dot import to_dot
    from launcher.graph.observer import Observer
    from launcher.graph.snapshot import DEBUG_TOPICS
    from launcher.graph.svg import to_svg

    with Observer() as observer:
        snapshot = observer.wait_for(
            lambda s: len(s.nodes) == NODES and set(s.topics()) >= TOPICS and len(_ends(s)) == ENDS,
            deadline_s=30.0,
        )
    if len(snapshot.nodes) != NODES:
        print(f"error: only these came up: {', '.join(snapshot.nodes)}", file=sys.stderr)
        return 1
    target.write_text(to_svg(to_dot(snapshot.without(DEBUG_TOPICS))), encoding="utf-8")
    print(f"wrote {target}: {len(snapshot.nodes)} nodes, {len(_ends(snapshot))} endpoints")
    return 0


def _ends(snapshot: object) -> list[object]:
    return [e for e in snapshot.endpoints if e.topic in TOPICS]  # type: ignore[attr-defined]


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
