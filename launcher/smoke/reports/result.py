"""Result: what came of a smoke run, and the exit code that tells it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from launcher.errors import ExitCode
from launcher.smoke.expect.expectation import Expectation, Outcome, Verdict
from launcher.smoke.observe.facts import Facts


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """An expectation and the verdict on it."""

    expectation: Expectation
    verdict: Verdict

    @property
    def is_met(self) -> bool:
        """Whether it holds."""
        return self.verdict.outcome is Outcome.MET


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """`trouble` is why the run could not be judged as it should, a sentence; None is well.

    `gave_up` is whether the system was not ready in time, `interrupted` the exit code if somebody
    stopped the run; `last_words` are the launcher's where it has started nothing.
    """

    judged: tuple[Judged, ...]
    facts: Facts
    folder: Path
    words: tuple[str, ...]
    domain_id: int
    run_id: str | None = None
    gave_up: bool = False
    trouble: str | None = None
    interrupted: ExitCode | None = None
    last_words: tuple[str, ...] = ()

    @property
    def failures(self) -> tuple[Judged, ...]:
        """What does not hold."""
        return tuple(one for one in self.judged if not one.is_met)

    @property
    def exit_code(self) -> ExitCode:
        """By what weighs most."""
        ending = self.facts.ending
        if self.interrupted is not None:
            return self.interrupted
        if ending is not None and ending.returncode == ExitCode.USAGE and not _began(self.facts):
            return ExitCode.USAGE
        if self.gave_up:
            return ExitCode.NOT_READY
        if any(not one.expectation.implicit for one in self.failures):
            return ExitCode.NOT_MET
        return ExitCode.PROCESS_FAILED if self.failures or self.trouble else ExitCode.OK


def _began(facts: Facts) -> bool:
    return bool(facts.processes())


def worst(codes: Sequence[ExitCode]) -> ExitCode:
    """The exit code of several runs."""
    order = (
        ExitCode.INTERRUPTED,
        ExitCode.TERMINATED,
        ExitCode.USAGE,
        ExitCode.NOT_READY,
        ExitCode.NOT_MET,
        ExitCode.PROCESS_FAILED,
    )
    return next((code for code in order if code in codes), ExitCode.OK)
