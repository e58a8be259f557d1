"""The verbs against the fleet, as docs/fleet.md tells its readers to type them."""

from __future__ import annotations

from tests.support.domain import private_domain
from tests.support.verbs import launcher


def test_the_probe_that_hears_nothing_is_explained(tmp_path):
    with private_domain(tmp_path) as domain:
        domain.start("robot_1")
        domain.start("qos_probe")
        domain.wait_for_nodes("robot_1", "qos_probe")
        answer = launcher(domain.env, "topic", "info", "/fleet/status", "-v")
        assert "  Reliability: BEST_EFFORT\n" in answer.out
        assert answer.out.endswith(
            "QoS: 1 of 1 pair of publisher and subscription does not match\n"
            "  /qos_probe receives nothing from /robot_1\n"
            "    RELIABILITY: the publisher offers BEST_EFFORT, "
            "the subscription asks for RELIABLE\n"
            "    to repair: set the subscription's reliability to BEST_EFFORT, "
            "or the publisher's to RELIABLE\n"
        )
        processes = launcher(domain.env, "node", "ps", "--json").json()
        pids = {row["node"]: row["pid"] for row in processes}
        assert pids["/robot_1"] == domain.nodes[0].pid
        assert pids["/qos_probe"] == domain.nodes[1].pid
