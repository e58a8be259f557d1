"""Waiting for observations, with errors that say what was observed instead."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, TypeVar

from launcher.base.document.quantities import INFINITY, NumberRange
from launcher.base.model.run_events import Ended
from launcher.smoke.expect.expectation import Decision, Expectation, Verdict
from launcher.smoke.judges import explain, judge
from launcher.smoke.observe.fact_recorder import FactRecorder
from launcher.smoke.observe.facts import Facts, LogLine, ProcessEvent

T = TypeVar("T")


class NotSeenError(AssertionError):
    """What was waited for was not observed in time."""


class Waits:
    """All times are bounded; a wait that times out raises NotSeenError."""

    def __init__(self, recorder: FactRecorder) -> None:
        self.recorder = recorder

    def facts(self) -> Facts:
        return self.recorder.facts()

    def wait_for(
        self,
        fact: Callable[[Facts], T | None],
        what: str,
        within_s: float = 10.0,
        guess: Callable[[Facts], str | None] = lambda _: None,
    ) -> T:
        """The first true result of `fact`; `guess` gives a probable cause for the error."""
        found = self.recorder.wait_for(fact, within_s)
        if not found:
            facts = self.facts()
            reason = guess(facts)
            maybe = f"\nmaybe: {reason}\n" if reason else "; "
            lines = [f"[{line.process or 'launch'}] {line.plain}" for line in facts.lines]
            shown = "\n".join(f"    {line}" for line in lines[-15:])
            raise NotSeenError(f"not within {within_s:g} s: {what}{maybe}the last lines:\n{shown}")
        return found

    def wait_for_expectation(self, expectation: Expectation, within_s: float) -> Verdict:
        def if_met(facts: Facts) -> Verdict | None:
            verdict = judge(expectation, facts)
            return verdict if verdict.outcome is Decision.MET else None

        found = self.recorder.wait_for(if_met, within_s)
        if found is not None:
            return found
        verdict = judge(expectation, self.facts())
        guess = f"\nmaybe: {verdict.guess}" if verdict.guess else ""
        raise NotSeenError(
            f"not within {within_s:g} s: {verdict.expected}\nseen: {verdict.seen}{guess}"
        )

    def wait_for_log(
        self,
        pattern: str,
        *,
        process: str = "*",
        level: str | None = None,
        within_s: float = 10.0,
        since_s: float = 0.0,
        count: int = 1,
    ) -> LogLine:
        """The `count`-th matching line after `since_s` (time of the run).

        The process `launch` is the launcher itself.
        """
        wanted = re.compile(pattern)

        def found(facts: Facts) -> LogLine | None:
            lines = [
                line
                for line in facts.lines
                if line.at_s >= since_s
                and wanted.search(line.plain)
                and level in (None, line.level)
                and facts.is_from(line, process)
            ]
            return lines[count - 1] if len(lines) >= count else None

        def guess(facts: Facts) -> str | None:
            return explain.missing_line(wanted, process, level, since_s, facts)

        of = "" if process == "*" else f" from {process}"
        return self.wait_for(found, f"a line with '{pattern}'{of}", within_s, guess)

    def wait_for_node(self, name: str, within_s: float = 10.0) -> Verdict:
        return self.wait_for_expectation(Expectation(kind="node", subject=name), within_s)

    def wait_for_topic(
        self,
        topic: str,
        type: str | None = None,
        *,
        publishers: int = 1,
        subscriptions: int = 0,
        within_s: float = 10.0,
    ) -> Verdict:
        """Until the topic exists with at least so many endpoints."""
        values: dict[str, Any] = {
            "publishers": NumberRange(low=publishers, high=INFINITY, text=f">= {publishers}"),
            "subscriptions": NumberRange(
                low=subscriptions, high=INFINITY, text=f">= {subscriptions}"
            ),
        }
        if type is not None:
            values["type"] = type
        wanted = Expectation(kind="topic", subject=topic, values=values)
        return self.wait_for_expectation(wanted, within_s)

    def wait_for_exit(self, process: str, within_s: float = 10.0) -> ProcessEvent[Ended]:
        """The exit of a process; its `event` has `returncode` and `asked`."""

        def found(facts: Facts) -> ProcessEvent[Ended] | None:
            ends = [end for name in facts.named(process) if (end := facts.last_end(name))]
            return ends[-1] if ends else None

        def guess(facts: Facts) -> str | None:
            return explain.unknown_process(process, facts)

        return self.wait_for(found, f"{process} exits", within_s, guess)
