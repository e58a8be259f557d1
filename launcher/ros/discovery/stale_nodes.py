"""Nodes that rmw still lists although their participant has gone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Set

_KEEP_NAMES = 1000
_KEEP_PARTICIPANTS = 8  # of a node; it may have restarted often


class StaleNodes:
    """Recognizes such nodes by the participants that had their endpoints.

    rmw keeps the list of nodes that a participant sends even if it takes it, in another thread,
    after it has removed the participant. So a node that ends while this machine is busy may stay
    for ever, without endpoints. One that never had endpoints may be real.
    """

    def __init__(self) -> None:
        self._owners: dict[str, list[str]] = {}  # participants of each node, newest last

    def without(
        self,
        nodes: Iterable[str],
        owners: Mapping[str, Set[str]],
        participants: Callable[[], Set[str]],
    ) -> list[str]:
        """The nodes without stale ones.

        A name comes as often as there are nodes with it. `owners` are the participants that have
        endpoints of a node now, `participants` are all that there are.
        """
        nodes = list(nodes)
        surplus: dict[str, int] = {}
        for name, count in Counter(nodes).items():
            self._learn(name, owners.get(name, frozenset()))
            surplus[name] = count - len(owners.get(name, ()))
        self._forget()
        if all(more <= 0 for more in surplus.values()) or not (there := participants()):
            return nodes
        stale = Counter(
            {
                name: min(more, len(set(self._owners[name]) - there))
                for name, more in surplus.items()
                if more > 0
            }
        )
        return [name for name in nodes if not _take(stale, name)]

    def _learn(self, name: str, owners: Set[str]) -> None:
        known = [one for one in self._owners.pop(name, ()) if one not in owners]
        self._owners[name] = [*known, *sorted(owners)][-_KEEP_PARTICIPANTS:]

    def _forget(self) -> None:
        """Forget the nodes that were not listed for the longest time."""
        for name in list(self._owners)[: -_KEEP_NAMES or None]:
            del self._owners[name]


def _take(stale: Counter[str], name: str) -> bool:
    if stale[name] <= 0:
        return False
    stale[name] -= 1
    return True
