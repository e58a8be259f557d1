"""Names of nodes that come back after their participant was lost for a while."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Set
from dataclasses import replace

from launcher.ros.discovery.gids import participant_of
from launcher.ros.snapshot.ros_graph import Endpoint

_KEEP = 20_000  # endpoints


class ReturnedNodes:
    """Remembers which node an endpoint belongs to, by its GID, which stays the same.

    A participant that was silent for longer than its lease (20 s) is removed, with its list of
    nodes. When the link is back Fast DDS discovers its endpoints again, but does not deliver the
    list, whose last sample the reader has had (measured with 24 s without a link, in 4 of 4
    trials): for rmw the endpoints then belong to an unknown node, until the list changes.
    """

    def __init__(self) -> None:
        self._nodes: dict[str, str] = {}
        self.names: frozenset[str] = frozenset()  # of the nodes that were named in the last call

    def named(self, endpoints: Iterable[Endpoint]) -> list[Endpoint]:
        """Those with a name, and those whose name is remembered."""
        every = [*endpoints]
        found = [one for one in every if one.has_name]
        self._nodes.update({one.gid: one.node for one in found if one.gid})
        returned = [*self._returned(every, {participant_of(one.gid) for one in found})]
        self.names = frozenset(one.node for one in returned)
        while len(self._nodes) > _KEEP:
            del self._nodes[next(iter(self._nodes))]
        return [*found, *returned]

    def _returned(self, endpoints: Iterable[Endpoint], listed: Set[str]) -> Iterator[Endpoint]:
        """`listed`: participants whose nodes are known; what has no name there is being removed."""
        for one in endpoints:
            node = None if one.has_name else self._nodes.get(one.gid)
            if node is not None and participant_of(one.gid) not in listed:
                yield replace(one, node=node)
