"""How a run looked in the end: for the page of a report; the judges do not need it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from launcher.control.active_runs import ListedRun


class LastState:
    """`rows` of `ps`, and the probe's `graphs`, one for each set of nodes, until `stop`."""

    def __init__(self) -> None:
        self.run: ListedRun | None = None
        self.rows: tuple[Mapping[str, Any], ...] = ()
        self.graphs: list[dict[str, Any]] = []
        self._nodes: set[tuple[str, bool]] = set()
        self._is_over = False

    def take_rows(self, rows: Sequence[Mapping[str, Any]]) -> None:
        if not self._is_over:
            self.rows = tuple(rows)

    def take_graph(self, graph: dict[str, Any]) -> None:
        if self._is_over:
            return
        nodes = {(node["name"], bool(node.get("ghost"))) for node in graph["nodes"]}
        if self.graphs and nodes == self._nodes:
            self.graphs.pop()  # of a starting system there are hundreds
        self.graphs.append(graph)
        self._nodes = nodes

    def stop(self) -> None:
        """What comes now is the end of the system."""
        self._is_over = True
