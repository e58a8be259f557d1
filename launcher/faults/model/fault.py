"""A fault of a watched run: an expectation that does not hold, with its evidence."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from launcher.faults.model.fault_life import Debounce, FaultLife, FaultState


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultFinding:
    """What was seen instead of what is expected, now; whom it concerns.

    `since_s`: since when, in time of the run; `certain`: it needs no confirmation; `times`: how
    many violations it stands for; `guess`: a probable cause that the judge has found. `settles`: it
    may be of a process that is just starting, and pass. `lack`: the part, 0 to 1, of what is
    expected that is missing.
    """

    seen: str
    value: float | None = None
    unit: str = ""
    processes: tuple[str, ...] = ()
    nodes: tuple[str, ...] = ()
    topics: tuple[str, ...] = ()
    message: Any = None
    guess: str | None = None
    since_s: float | None = None
    certain: bool = False
    settles: bool = True
    lack: float = 0.0
    times: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultOrigin:
    """Which expectation a fault is of: `place` is None for those of every watched run.

    `fault` is the id in the run: the name of the expectation, and what it is about where it is
    about several.
    """

    fault: str
    expectation: str
    kind: str
    expected: str
    place: str | None = None


@dataclass(slots=True)
class Fault:
    """One fault of a run, which may come again; `is_certain`: its cause is not weak."""

    origin: FaultOrigin
    life: FaultLife
    finding: FaultFinding
    lines: tuple[str, ...] = ()
    cause: str | None = None
    rule: str | None = None
    is_certain: bool = False
    follows: str | None = None
    incident: int | None = None
    acknowledged: dict[str, Any] | None = None
    muted: dict[str, Any] | None = None

    @classmethod
    def of(cls, origin: FaultOrigin, debounce: Debounce, finding: FaultFinding) -> Fault:
        return cls(origin, FaultLife(debounce), finding)

    @classmethod
    def resumed(cls, document: Mapping[str, Any], run_time_of: Callable[[float], float]) -> Fault:
        """One that another watcher has reported; `run_time_of` is the reverse of `wall_of`."""

        def at(name: str) -> float | None:
            wall_s = document[name]
            return None if wall_s is None else run_time_of(wall_s)

        origin = FaultOrigin(
            **{name: document[name] for name in ("fault", "expectation", "kind", "expected")},
            place=document["place"],
        )
        finding = FaultFinding(
            **{name: document[name] for name in ("seen", "value", "unit", "message")},
            processes=tuple(document["processes"]),
            nodes=tuple(document["nodes"]),
            topics=tuple(document["topics"]),
        )
        fault = cls(origin, FaultLife(Debounce()), finding, lines=tuple(document["lines"]))
        for name in ("cause", "rule", "follows", "incident", "acknowledged", "muted"):
            setattr(fault, name, document[name])
        fault.is_certain = fault.cause is not None
        times_s = at("first_s") or 0.0, at("confirmed_s"), at("last_s") or 0.0, at("healed_s")
        fault.life.resume(FaultState(document["state"]), document["count"], times_s)
        return fault

    @property
    def id(self) -> str:
        return self.origin.fault

    @property
    def is_active(self) -> bool:
        return self.life.state is FaultState.ACTIVE

    def document(self, wall_of: Callable[[float], float]) -> dict[str, Any]:
        """As in docs/reference/faults.md; `wall_of` makes seconds since 1970 of a time of the run.

        A dismissed one is `healed` with `confirmed_s` null. The cause of the last time says nothing
        of one that is suspected again, nor a weak one of what follows from another.
        """
        origin, life, finding = self.origin, self.life, self.finding
        state = FaultState.HEALED if life.state is None else life.state
        is_explained = state is not FaultState.SUSPECTED
        has_cause = is_explained and (self.is_certain or self.follows is None)

        def wall(at_s: float | None) -> float | None:
            return None if at_s is None else round(wall_of(at_s), 3)

        return {
            "fault": origin.fault,
            "expectation": origin.expectation,
            "kind": origin.kind,
            "place": origin.place,
            "state": state.value,
            "expected": origin.expected,
            "seen": finding.seen,
            "value": finding.value,
            "unit": finding.unit,
            "first_s": wall(life.first_s),
            "confirmed_s": wall(life.confirmed_s),
            "last_s": wall(life.last_s),
            "healed_s": wall(life.healed_s),
            "count": life.count,
            "lines": list(self.lines),
            "message": finding.message,
            "processes": list(finding.processes),
            "nodes": list(finding.nodes),
            "topics": list(finding.topics),
            "cause": self.cause if has_cause else None,
            "rule": self.rule if has_cause else None,
            "follows": self.follows if is_explained else None,
            "incident": self.incident if is_explained else None,
            "acknowledged": self.acknowledged,
            "muted": self.muted,
        }
