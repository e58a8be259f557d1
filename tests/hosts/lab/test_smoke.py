"""Expectations on nodes that run on other hosts, over ssh."""

from __future__ import annotations

from tests.support.hosts import Lab
from tests.support.repository import REPOSITORY

EXPECTED = """\
expect:
  - {node: /robot_1, within: 60 s}
  - {topic: /fleet/status, publishers: 3, within: 60 s}
  - {log: task, process: robot_1, within: 60 s}
"""


def smoke(lab: Lab, place: str, *words: str) -> tuple[int, str]:
    host = lab.host(place)
    file = lab.hosts_file(lab.operator.home / "hosts.yaml", [host], {"robot_1": place})
    command = ("smoke", "system", "--hosts", file, *words)
    done = lab.operator.launcher(*command, cwd=REPOSITORY)
    return done.returncode, done.stdout + done.stderr


def test_expectations_hold_for_nodes_on_other_hosts(lab: Lab):
    file = lab.operator.home / "expected.yaml"
    file.write_text(EXPECTED, encoding="utf-8")
    code, text = smoke(lab, "bot1", "--expect", str(file))

    assert code == 0, text


def test_an_expectation_that_a_node_there_does_not_meet_fails(lab: Lab):
    code, text = smoke(lab, "bot2", "--no-file", "--expect-log-count", "robot_1: task=0")

    assert code not in (0, 2, 124), text
    assert "robot_1" in text
