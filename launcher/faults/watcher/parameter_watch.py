"""Asks nodes for the parameters that expectations are about, in a thread.

A node is asked when it appears, when it reports a change on `/parameter_events`, and now and then,
since events can be lost or switched off.
"""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Iterable, Mapping
from typing import Any

from launcher.base.errors import LauncherError
from launcher.faults.watcher.observations import Observations
from launcher.smoke.expect.expectation import Expectation
from launcher.smoke.observe.facts import ObservedMessage, QueryAnswer
from launcher.smoke.observe.probe_client import ProbeClient

PERIOD_S = 10.0
RETRY_S = 1.0  # after an error, and of a node that has just appeared
ANSWER_S = 2.0  # a busy node may answer the next time
EVENTS = "/parameter_events"

Node = Mapping[str, Any]  # of the event `graph` of the probe


class ParameterWatch:
    """`see` and `take` are called by one thread."""

    def __init__(
        self, probe: ProbeClient, observations: Observations, expectations: Iterable[Expectation]
    ) -> None:
        self._probe = probe
        self._observations = observations
        self._wanted: dict[str, list[Expectation]] = {}
        for one in expectations:
            if one.kind == "parameter":
                self._wanted.setdefault(str(one.get("node")), []).append(one)
        self._pids: dict[str, int | None] = {}  # of the nodes that are there
        self._due = queue.SimpleQueue[str | None]()  # None: the end
        self._is_over = False
        if self._wanted:
            probe.send("subscribe", sub=EVENTS, topic=EVENTS, type=None, qos=None)
            threading.Thread(target=self._work, daemon=True, name="parameters").start()

    def see(self, nodes: Iterable[Node]) -> None:
        """The nodes that are there now; another process of the same name is another node."""
        before = self._pids
        self._pids = {one["name"]: one.get("pid") for one in nodes if one["name"] in self._wanted}
        for name, pid in self._pids.items():
            if name not in before or pid != before[name]:
                self._due.put(name)

    def take(self, messages: Iterable[ObservedMessage]) -> None:
        """Look for changes of parameters in what has just been received."""
        for message in messages:
            if message.watch == EVENTS and isinstance(message.content, dict):
                name = message.content.get("node")
                if name in self._wanted:
                    self._due.put(str(name))

    def _work(self) -> None:
        """Ask those that are due, each once however often it was named."""
        due_s = dict.fromkeys(self._wanted, 0.0)
        while not self._is_over and self._probe.is_alive:
            named = self._named(min(due_s.values()) - time.monotonic())
            now_s = time.monotonic()
            for node, wanted in self._wanted.items():
                if self._is_over or (node not in named and now_s < due_s[node]):
                    continue
                is_answered = node in self._pids and self._ask(node, wanted)
                due_s[node] = now_s + (PERIOD_S if is_answered else RETRY_S)

    def _named(self, wait_s: float) -> set[str | None]:
        """Those that are in the queue, or come within this time."""
        named: set[str | None] = set()
        with contextlib.suppress(queue.Empty):
            named.add(self._due.get(timeout=max(0.0, wait_s)))
            while True:
                named.add(self._due.get_nowait())
        return named

    def _ask(self, node: str, wanted: list[Expectation]) -> bool:
        """Whether there is an answer."""
        names = [str(one.subject) for one in wanted]
        try:
            answer = self._probe.ask(
                "get_parameters", timeout_s=ANSWER_S, node=node, names=sorted(set(names))
            )
        except LauncherError as error:
            for one in wanted:
                self._add(one, QueryAnswer(at_s=self._now_s, error=error.message))
            return False
        for one in wanted:
            if one.subject in answer["missing"]:
                found = QueryAnswer(at_s=self._now_s, value=None)
            else:
                found = QueryAnswer(at_s=self._now_s, value=answer["values"][one.subject])
            self._add(one, found)
        return True

    @property
    def _now_s(self) -> float:
        return self._observations.now_s

    def _add(self, one: Expectation, answer: QueryAnswer) -> None:
        self._observations.add_answer(one.key, answer)

    def close(self) -> None:
        self._is_over = True
        self._due.put(None)
