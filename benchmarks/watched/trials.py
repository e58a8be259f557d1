"""Injects faults into watched systems, and measures what is found."""

from __future__ import annotations

import contextlib
import random
import time
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from benchmarks.harness import NotHereError, Row, median, scratch
from benchmarks.watched.injections import INJECTIONS, Injection
from benchmarks.watched.system import WatchedSystem

FOUND_S = 10.0  # a fault that is not found by then is missed
CAUSE_S = 1.5  # faults that are confirmed together
HEAL_S = 60.0
MOST_PAUSE_S = 3.0


class Trial(NamedTuple):
    """`seconds` from the injection to the first fault that was confirmed; None: none was.

    `rule` is what explains that fault; `wanted` what should.
    """

    kind: str
    seed: int
    wanted: str
    seconds: float | None
    rule: str | None
    cause: str | None
    is_healed: bool

    @property
    def is_right(self) -> bool:
        return self.rule == self.wanted


def trials(kind: str, seeds: Iterable[int]) -> Iterator[Trial]:
    """One system for all seeds of a kind."""
    injection = INJECTIONS[kind]
    with scratch() as folder, contextlib.ExitStack() as stack:
        surroundings = None
        if injection.within is not None:
            surroundings = stack.enter_context(injection.within(folder))
        system = stack.enter_context(WatchedSystem(folder, surroundings))
        for seed in seeds:
            yield _trial(system, kind, injection, seed)


def _trial(system: WatchedSystem, kind: str, injection: Injection, seed: int) -> Trial:
    chance = random.Random(seed)
    time.sleep(chance.uniform(0.0, MOST_PAUSE_S))
    before_s = time.time()
    seconds, rule, cause = None, None, None
    with injection.make(system, chance):
        begun_s = time.time()
        deadline_s = begun_s + FOUND_S
        while time.time() < deadline_s and not system.confirmed(before_s):
            time.sleep(0.02)
        if found := system.confirmed(before_s):
            at_s, fault = found[0]
            seconds, rule, cause = max(0.0, at_s - begun_s), fault["rule"], fault["cause"]
            time.sleep(CAUSE_S)
    return Trial(kind, seed, injection.rule, seconds, rule, cause, system.await_health(HEAL_S))


def injected_faults(runs: int) -> list[Row]:
    """All kinds that are possible here, with so many seeds each."""
    found: list[Trial] = []
    missing = []
    for kind in INJECTIONS:
        try:
            found += trials(kind, range(runs))
        except NotHereError as error:
            missing.append(f"{kind}: {error}")
    seconds = [FOUND_S if one.seconds is None else one.seconds for one in found]
    slow = max(found, key=lambda one: FOUND_S if one.seconds is None else one.seconds)
    detail = "; ".join([f"{len(found)} faults", *missing])
    wrong = ", ".join(sorted({one.kind for one in found if not one.is_right}))
    share_found = sum(one.seconds is not None for one in found) / len(found) * 100
    share_right = sum(one.is_right for one in found) / len(found) * 100
    return [
        Row("injected faults that are found", share_found, "%", 95.0, detail, at_least=True),
        Row("of them with the right cause", share_right, "%", 90.0, wrong, at_least=True),
        Row("until they are confirmed, the slowest", max(seconds), "s", 3.0, slow.kind),
    ]


def summary(found: list[Trial]) -> str:
    """A row of the table."""
    seconds = [one.seconds for one in found if one.seconds is not None]
    right = sum(one.is_right for one in found)
    texts = sorted({one.cause or "none" for one in found if not one.is_right})
    times = f"{median(seconds):.1f} s, at most {max(seconds):.1f} s" if seconds else "-"
    wrong = f" ({'; '.join(texts)})" if texts else ""
    return f"{len(seconds)} of {len(found)} | {times} | {right} of {len(found)}{wrong}"
