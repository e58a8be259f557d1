"""Looks whether the facts of one life of a process hold."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from launcher.base.model.supervision import GRAPH_KINDS, Fact
from launcher.output.filters import Pattern, TooSlowError
from launcher.output.lines import without_colour
from launcher.posix.reactor import Reactor
from launcher.run.processes.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.helpers.graph_facts import GraphFacts
    from launcher.run.ready.attempts import CommandRun, PortAttempts


class ReadyWatch:
    """From the start of a process until it is ready or ends; close it.

    `report(index, holds, text)` is called with what is seen of a fact. `env` is the environment of
    the process.
    """

    def __init__(
        self,
        process: Process,
        facts: Sequence[Fact],
        report: Callable[[int, bool, str], None],
        *,
        reactor: Reactor,
        graph: Callable[[], GraphFacts],
        env: Mapping[str, str],
    ) -> None:
        self._process = process
        self._report = report
        self._patterns: dict[int, Pattern] = {}
        self._attempts: list[CommandRun | PortAttempts] = []
        self._graph: GraphFacts | None = None
        self._numbers: list[int] = []
        for index, fact in enumerate(facts):
            self._begin(index, fact, reactor, graph, env)
        if self._patterns:
            process.on_lines = self._read

    def _begin(
        self,
        index: int,
        fact: Fact,
        reactor: Reactor,
        graph: Callable[[], GraphFacts],
        env: Mapping[str, str],
    ) -> None:
        def report(holds: bool, text: str) -> None:
            self._report(index, holds, text)

        if fact.kind == "log":
            self._patterns[index] = Pattern(fact.subject)
        elif fact.kind in GRAPH_KINDS:
            self._graph = graph()
            self._numbers.append(self._graph.watch(fact, env, reactor.now(), report))
        elif fact.kind in ("port", "command"):
            from launcher.run.ready.attempts import CommandRun, PortAttempts

            if fact.kind == "port":
                self._attempts.append(PortAttempts(fact, reactor, report))
            else:
                cwd = None if self._process.host is not None else self._process.spec.cwd
                self._attempts.append(CommandRun(fact, reactor, report, env=env, cwd=cwd))

    def _read(self, lines: bytes) -> None:
        split = without_colour(lines).splitlines()
        for index, pattern in list(self._patterns.items()):
            try:
                found = bool(pattern.choose(split))
            except TooSlowError:
                self._report(index, False, f"the search for '{pattern.text}' takes too long")
                continue
            if found:
                del self._patterns[index]
                self._report(index, True, "")
        if not self._patterns:
            self._process.on_lines = None

    def close(self) -> None:
        self._process.on_lines = None
        for attempt in self._attempts:
            attempt.close()
        for number in self._numbers:
            assert self._graph is not None
            self._graph.unwatch(number)
        self._attempts.clear()
        self._numbers.clear()
