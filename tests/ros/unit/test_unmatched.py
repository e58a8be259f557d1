"""What verbs say about endpoints that do not match theirs."""

from __future__ import annotations

import pytest

from launcher.ros.snapshot.qos_matching import Mismatch
from launcher.ros.snapshot.ros_graph import UNKNOWN_NAMESPACE, UNKNOWN_NODE, Direction, Endpoint
from launcher.ros.topics import unmatched
from launcher.ros.topics.unmatched import Unmatched

NAMELESS = f"{UNKNOWN_NAMESPACE}/{UNKNOWN_NODE}"


def end(node: str, direction: Direction, reliability: str) -> Endpoint:
    return Endpoint(
        topic="/t",
        node=node,
        direction=direction.value,
        type="std_msgs/msg/String",
        reliability=reliability,
        durability="VOLATILE",
    )


OWN = end("this command", Direction.SUBSCRIPTION, "RELIABLE")
GOOD = end("/good", Direction.PUBLISHER, "RELIABLE")
BAD = end("/bad", Direction.PUBLISHER, "BEST_EFFORT")


def text(found: list[Mismatch], reasons: str) -> str:
    return reasons


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [100.0]
    monkeypatch.setattr(unmatched.time, "monotonic", lambda: now[0])
    return now


def test_a_mismatch_is_told_once(clock):
    told = Unmatched()
    assert told.news([GOOD, OWN], text) is None
    assert "this command receives nothing from /bad\n" in told.news([GOOD, BAD, OWN], text)
    assert told.news([GOOD, BAD, OWN], text) is None


def test_a_name_is_waited_for(clock):
    told, nameless = Unmatched(), end(NAMELESS, Direction.PUBLISHER, "BEST_EFFORT")
    assert told.news([nameless, OWN], text) is None
    assert "from /bad\n" in told.news([BAD, OWN], text)


def test_a_name_that_does_not_arrive_is_not_waited_for_without_end(clock):
    told, nameless = Unmatched(), end(NAMELESS, Direction.PUBLISHER, "BEST_EFFORT")
    assert told.news([nameless, OWN], text) is None
    clock[0] += 2.5
    said = told.news([nameless, OWN], text)
    assert "from a node whose name is not known yet\n" in said
    assert "UNKNOWN" not in said
