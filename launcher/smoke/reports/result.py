"""The result of a smoke run, and its exit code."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from launcher.base.errors import ExitCode
from launcher.smoke.expect.expectation import Decision, Expectation, Verdict
from launcher.smoke.observe.facts import Facts
from launcher.smoke.observe.last_state import LastState


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """`decided_s`: when the verdict was known; None: at the end."""

    expectation: Expectation
    verdict: Verdict
    decided_s: float | None = None

    @property
    def is_met(self) -> bool:
        return self.verdict.outcome is Decision.MET


@dataclass(frozen=True, slots=True, kw_only=True)
class SmokeResult:
    """`trouble`: why the run failed as a whole; `gave_up`: the system was not ready in time.

    `interrupted`: the exit code of an interrupted run; `last_lines`: of the output of a launcher
    that has started nothing; `started_s`: seconds since the epoch; `last_state`: before the stop.
    """

    judged: tuple[Judged, ...]
    facts: Facts
    folder: Path
    words: tuple[str, ...]
    domain_id: int
    gave_up: bool = False
    trouble: str | None = None
    interrupted: ExitCode | None = None
    last_lines: tuple[str, ...] = ()
    started_s: float = 0.0
    last_state: LastState | None = None

    @property
    def failures(self) -> tuple[Judged, ...]:
        return tuple(one for one in self.judged if not one.is_met)

    @property
    def exit_code(self) -> ExitCode:
        ending = self.facts.ending
        if self.interrupted is not None:
            return self.interrupted
        if (
            ending is not None
            and ending.returncode == ExitCode.USAGE
            and not self.facts.processes()
        ):
            return ExitCode.USAGE
        if self.gave_up:
            return ExitCode.NOT_READY
        if any(not one.expectation.implicit for one in self.failures):
            return ExitCode.NOT_MET
        return ExitCode.PROCESS_FAILED if self.failures or self.trouble else ExitCode.OK


def worst(codes: Sequence[ExitCode]) -> ExitCode:
    order = (
        ExitCode.INTERRUPTED,
        ExitCode.TERMINATED,
        ExitCode.USAGE,
        ExitCode.NOT_READY,
        ExitCode.NOT_MET,
        ExitCode.PROCESS_FAILED,
    )
    return next((code for code in order if code in codes), ExitCode.OK)
