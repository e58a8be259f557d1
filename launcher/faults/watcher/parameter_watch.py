"""Asks nodes for the parameters that expectations are about, in a thread."""

from __future__ import annotations

import threading
from collections.abc import Iterable

from launcher.base.errors import LauncherError
from launcher.faults.watcher.observations import Observations
from launcher.smoke.expect.expectation import Expectation
from launcher.smoke.observe.facts import QueryAnswer
from launcher.smoke.observe.probe_client import ProbeClient

PERIOD_S = 1.0
ANSWER_S = 2.0  # a busy node may answer the next time


class ParameterWatch:
    """One request a second for each node, from when it is in the graph."""

    def __init__(
        self, probe: ProbeClient, observations: Observations, expectations: Iterable[Expectation]
    ) -> None:
        self._probe = probe
        self._observations = observations
        self._wanted: dict[str, list[Expectation]] = {}
        for one in expectations:
            if one.kind == "parameter":
                self._wanted.setdefault(str(one.get("node")), []).append(one)
        self._nodes: frozenset[str] = frozenset()
        self._is_over = threading.Event()
        if self._wanted:
            threading.Thread(target=self._poll, daemon=True, name="parameters").start()

    def see(self, nodes: Iterable[str]) -> None:
        """The nodes that are there now."""
        self._nodes = frozenset(nodes)

    def _poll(self) -> None:
        while not self._is_over.wait(PERIOD_S) and self._probe.is_alive:
            for node, wanted in self._wanted.items():
                if node in self._nodes and not self._is_over.is_set():
                    self._ask(node, wanted)

    def _ask(self, node: str, wanted: list[Expectation]) -> None:
        names = [str(one.subject) for one in wanted]
        try:
            answer = self._probe.ask(
                "get_parameters", timeout_s=ANSWER_S, node=node, names=sorted(set(names))
            )
        except LauncherError as error:
            for one in wanted:
                self._add(one, QueryAnswer(at_s=self._now_s, error=error.message))
            return
        for one in wanted:
            if one.subject in answer["missing"]:
                found = QueryAnswer(at_s=self._now_s, value=None)
            else:
                found = QueryAnswer(at_s=self._now_s, value=answer["values"][one.subject])
            self._add(one, found)

    @property
    def _now_s(self) -> float:
        return self._observations.now_s

    def _add(self, one: Expectation, answer: QueryAnswer) -> None:
        self._observations.add_answer(one.key, answer)

    def close(self) -> None:
        self._is_over.set()
