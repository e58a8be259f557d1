"""Judge of a bag as the expectation: what was recorded is like it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from launcher.base.text import count, several
from launcher.smoke.expect.expectation import Decision, Expectation, Verdict
from launcher.smoke.expect.likeness import Likeness
from launcher.smoke.judges import explain
from launcher.smoke.judges.common import met, violated
from launcher.smoke.observe.facts import Facts

if TYPE_CHECKING:
    from launcher.bag.comparing.topic_traits import Tolerances, Traits

_SHOWN = 6  # differences; the folder of evidence has the recording


def like(expectation: Expectation, facts: Facts) -> Verdict:
    """Decided at the end, when the recording is whole."""
    good: Likeness = expectation.subject
    reference = good.reference
    expected = f"{count(len(reference), 'topic')} as in {good}"
    if not facts.is_over:
        return Verdict(outcome=Decision.OPEN, expected=expected)
    if facts.recorded is None:
        return violated(expected, seen="; ".join(("nothing was recorded", *facts.troubles)))
    recorded = facts.recorded
    faults: list[str] = []
    wrong: list[str] = []
    for name, traits in reference.items():
        if found := [*_faults(traits, recorded.get(name), good)]:
            wrong.append(name)
            faults += [f"{name}: {text}" for text in found]
    if not faults:
        number = sum(recorded[name].count for name in reference if name in recorded)
        return met(expected, seen=f"{number} messages")
    silent = (name for name in wrong if name not in recorded or not recorded[name].count)
    missing = next(silent, None)
    return violated(
        expected,
        seen=several(faults, most=_SHOWN).replace(", /", "; /"),
        guess=None if missing is None else explain.silence(missing, facts),
        about=tuple(dict.fromkeys(p for name in wrong for p in explain.processes_on(name, facts))),
    )


def _faults(good: Traits, found: Traits | None, likeness: Likeness) -> Iterator[str]:
    from launcher.bag.comparing.topic_traits import differences, text_of

    if found is None or (good.count and not found.count):
        if good.count or found is None:
            yield "no message" if found is not None else "not there"
        return
    for one in differences(good, found, _tolerances(likeness)):
        yield text_of(one, f"in {likeness}", "in this run")


def _tolerances(likeness: Likeness) -> Tolerances:
    from launcher.bag.comparing.topic_traits import Limit, Tolerances

    return Tolerances(
        rate=Limit(relative=likeness.rates_percent / 100),
        gap=Limit(relative=likeness.gaps_percent / 100),
    )
