"""One process on its way to its first start, and what it lacks to be ready."""

from __future__ import annotations

import enum

from launcher.base.model.spec import ProcessSpec
from launcher.base.model.supervision import Fact, StartRule


class StartPhase(enum.Enum):
    """How far a process is on its way to its first start."""

    NEW = enum.auto()
    WAITING = enum.auto()
    PASSED = enum.auto()


class WaitingProcess:
    """One process. `needs` are those that it waits for, by the names in its rule."""

    def __init__(self, spec: ProcessSpec, rule: StartRule) -> None:
        self.name = spec.name
        self._held: set[int] = set()
        self._said: dict[int, str] = {}
        self.rule = rule
        self.describe(spec, rule)
        self.phase = StartPhase.NEW
        self.admitted_s = self.passed_s = self.started_s = 0.0
        self.is_running = self.is_finished = False
        self.lives = 0
        self.ready_s: float | None = None
        self.gone = ""  # how it has ended for good before it was ready
        self.state = "it has not been started"

    def describe(self, spec: ProcessSpec, rule: StartRule) -> None:
        if rule.ready_when != self.rule.ready_when:
            self._held.clear()
            self._said.clear()
        self.spec, self.rule = spec, rule
        self.needs: dict[str, list[WaitingProcess]] = (
            {n: [] for n in rule.after.names} if rule.after else {}
        )

    @property
    def facts(self) -> tuple[Fact, ...]:
        return self.rule.ready_when or ()

    @property
    def is_satisfied(self) -> bool:
        return self.ready_s is not None or self.is_finished

    @property
    def lacks(self) -> list[int]:
        """The facts that have not held yet."""
        return [index for index in range(len(self.facts)) if index not in self._held]

    def begin(self, now: float) -> None:
        self.lives += 1
        self.is_running, self.is_finished, self.gone = True, False, ""
        self.started_s, self.ready_s = now, None
        self._held.clear()
        self._said.clear()

    def note(self, index: int, *, holds: bool, text: str) -> None:
        if holds:
            self._held.add(index)
        self._said[index] = text

    def note_exit(self, returncode: int | None) -> None:
        for index, fact in enumerate(self.facts):
            if fact.kind == "exit" and returncode == int(fact.subject):
                self._held.add(index)

    def lack(self) -> str:
        """What it lacks: `no publisher on /fleet/tasks`."""
        if not self.is_running:
            return self.gone or self.state
        index = self.lacks[0]
        return self._said.get(index) or _LACKS[self.facts[index].kind].format(
            self.facts[index].subject
        )


_LACKS = {
    "node": "no node {}",
    "publisher": "no publisher on {}",
    "subscription": "no subscription on {}",
    "message": "no message on {}",
    "service": "no service {}",
    "lifecycle": "its lifecycle state is not {}",
    "log": "no line with '{}'",
    "port": "no connection to {}",
    "command": "`{}` has not exited with code 0",
    "exit": "it has not exited with code {}",
}
