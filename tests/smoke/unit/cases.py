"""Test cases of a kind of expectation: facts that meet it, facts that do not, and the message."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from launcher.base.command_line import Command
from launcher.smoke.expect.expectation import Decision, Expectation
from launcher.smoke.observe.facts import QueryAnswer
from launcher.smoke.smoke_options import EXPECTATIONS
from tests.smoke.unit.facts import EMPTY, lines, verdict

STEPS = {"steps": {"kill": 5.0}}


@dataclass(frozen=True)
class Case:
    """An expectation, facts of which it is met, facts of which it is not, and what is said then."""

    entry: str
    good: dict[str, Any]
    bad: dict[str, Any]
    seen: str
    guess: str | None = None

    def check(self) -> None:
        """Assert that the good facts meet it, and the bad ones do not, with the right message."""
        good, bad = verdict(self.entry, **self.good), verdict(self.entry, **self.bad)
        assert good.outcome is Decision.MET, good
        assert bad.outcome is Decision.VIOLATED
        assert self.seen in bad.seen
        if self.guess is not None:
            assert bad.guess is not None and self.guess in bad.guess
        assert len(good.expected.split()) >= 3


def graphs(*found: Any) -> dict[str, Any]:
    return {"graphs": (EMPTY, *found)}


def answers(name: str, *found: QueryAnswer) -> dict[str, Any]:
    return {"answers": {name: found}}


def log(*found: str, **options: Any) -> dict[str, Any]:
    return {"lines": lines(*found, **options)}


def expectation_of(flag: str, text: str) -> Expectation:
    """The expectation that an option of the command line stands for; UsageError."""
    (found,) = Command("", "", options=EXPECTATIONS).parse([f"{flag}={text}"]).expectations
    assert isinstance(found, Expectation)
    return found
