"""When a graph is complete."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

from launcher.posix.domain_lease import leased_domain
from launcher.ros.discovery.completeness import settle
from launcher.ros.discovery.observer import Observer

SERVICES = 15  # one at each look: over a longer time than a graph has to be quiet


class ArrivingServices:
    """An observer that knows all nodes, and one service more whenever it is asked."""

    node = SimpleNamespace(get_publishers_info_by_topic=lambda _: [])
    is_introduced = True

    def __init__(self, domain_id: int) -> None:
        self.domain_id = domain_id
        self.looks = 0

    def participants(self) -> set[bytes]:
        return set()

    def own_gid(self) -> bytes:
        return b""

    def node_names(self) -> list[str]:
        return ["/pump"]

    def dds_topics(self) -> set[str]:
        self.looks += 1
        return {f"rq/pump/service_{number}Request" for number in range(min(self.looks, SERVICES))}


def test_a_graph_is_not_complete_while_services_arrive():
    with leased_domain() as domain_id:
        observer = ArrivingServices(domain_id)
        settle(cast("Observer", observer), 60.0)
    assert observer.looks > SERVICES
