"""When a graph is complete."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import cast

import pytest

from launcher.posix.domain_lease import leased_domain
from launcher.ros.discovery import completeness
from launcher.ros.discovery.gids import PARTICIPANT_BYTES
from launcher.ros.discovery.observer import Observer
from launcher.ros.snapshot.ros_graph import Direction, EndpointInfo, GraphSnapshot

LATE = 15  # looks: over a longer time than a graph has to be quiet
PUMP, ENDED = (bytes([number]) * PARTICIPANT_BYTES for number in (1, 2))
SERVICE = "rq/pump/get_parametersRequest"


class SilentObserver:
    """An observer that has found a node with a service; nothing changes any more."""

    node = SimpleNamespace(get_publishers_info_by_topic=lambda _: [])
    is_introduced = True
    is_prefetching = False

    def __init__(self, domain_id: int) -> None:
        self.domain_id = domain_id
        self.looks = 0

    def participants(self) -> set[bytes]:
        return {PUMP}

    def is_half_known(self) -> bool:
        return False

    def own_gid(self) -> bytes:
        return b""

    def node_names(self) -> list[str]:
        return ["/pump"]

    def dds_topics(self) -> set[str]:
        self.looks += 1
        return {SERVICE}

    def dds_infos(self, topic: str, direction: Direction) -> list[EndpointInfo]:
        return [] if direction is Direction.PUBLISHER else [endpoint()]

    def prefetched_graph(self) -> GraphSnapshot | None:
        return prefetched(endpoint())


class ArrivingServices(SilentObserver):
    """It has one service more whenever it is asked."""

    def dds_topics(self) -> set[str]:
        super().dds_topics()
        return {f"rq/pump/service_{number}Request" for number in range(min(self.looks, LATE))}

    def prefetched_graph(self) -> None:
        return None


class LateEndpoint(SilentObserver):
    """The topic of the service is known, but not who reads it."""

    def dds_infos(self, topic: str, direction: Direction) -> list[EndpointInfo]:
        return super().dds_infos(topic, direction) if self.looks > LATE else []


class LateName(SilentObserver):
    """The endpoint is known, but not its node."""

    def dds_infos(self, topic: str, direction: Direction) -> list[EndpointInfo]:
        return [endpoint(node="/pump" if self.looks > LATE else "")]


class LatePrefetch(SilentObserver):
    """The graph is still being read."""

    @property
    def is_prefetching(self) -> bool:
        return self.looks <= LATE


class LateSubscriptions(SilentObserver):
    """Of the participant, only what it publishes is known."""

    def is_half_known(self) -> bool:
        return self.looks <= LATE

    def prefetched_graph(self) -> None:
        return None


class EndedParticipant(SilentObserver):
    """A node was read whose participant has gone."""

    def prefetched_graph(self) -> GraphSnapshot | None:
        return prefetched(endpoint(), endpoint(ENDED, node="/tank"))


class DestroyedEndpoint(SilentObserver):
    """A service was read that its node does not offer any more."""

    def dds_infos(self, topic: str, direction: Direction) -> list[EndpointInfo]:
        return []


def endpoint(participant: bytes = PUMP, node: str = "/pump") -> EndpointInfo:
    return EndpointInfo(
        topic=SERVICE,
        node=node,
        direction=Direction.SUBSCRIPTION.value,
        type="rcl_interfaces::srv::dds_::GetParameters_Request_",
        reliability="RELIABLE",
        durability="VOLATILE",
        gid=f"{participant.hex('.')}.00.00.12.04",
    )


def prefetched(*infos: EndpointInfo) -> GraphSnapshot:
    return GraphSnapshot(domain_id=0, nodes=("/pump",), infos=infos)


def settled(kind: type[SilentObserver]) -> tuple[int, float]:
    """How often it looked, and for how long in seconds, with a minute to do so."""
    with leased_domain() as domain_id:
        observer = kind(domain_id)
        found = completeness.settle(cast("Observer", observer), 60.0)
    return observer.looks, found.waited_s


def test_a_graph_is_not_complete_while_services_arrive():
    assert settled(ArrivingServices)[0] > LATE


@pytest.mark.parametrize("kind", [LateEndpoint, LateName, LatePrefetch, LateSubscriptions])
def test_a_graph_is_not_complete_before_every_participant_is(kind, monkeypatch):
    monkeypatch.setattr(completeness, "_OUTDATED_S", math.inf)
    assert settled(kind)[0] > LATE


def test_a_participant_that_has_ended_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(completeness, "_OUTDATED_S", math.inf)
    assert settled(EndedParticipant)[1] < 60.0


def test_an_endpoint_that_was_destroyed_is_not_waited_for_long(monkeypatch):
    monkeypatch.setattr(completeness, "_OUTDATED_S", 0.2)
    assert settled(DestroyedEndpoint)[1] < 60.0
