"""What an earlier watcher of the run has judged, which a new one does not judge again."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from launcher.smoke.observe.facts import Facts, LogLine, ObservedMessage

# What happened so long before the earlier watcher wrote last may wait for its cause still: it is
# judged again, and is the same fault, since no check of lines heals sooner.
OPEN_S = 2.5
EARLIER_S = 5.0  # a new probe gets the last messages of TRANSIENT_LOCAL topics meanwhile


class Handover:
    """Times in seconds of the run. Of processes, all events count: what is dead has died before.

    The clock of a publisher may be behind: the time that it has sent a message at says only in the
    first seconds of a subscription whether that is of before.
    """

    def __init__(self) -> None:
        self._judged_s = self._earlier_to_s = -math.inf

    def resume(self, last_s: float) -> None:
        """An earlier watcher has reported last at this time, or an earlier probe ended."""
        self._judged_s = last_s - OPEN_S

    def subscribe(self, now_s: float) -> None:
        """A probe subscribes now."""
        self._earlier_to_s = now_s + EARLIER_S

    def unjudged(self, facts: Facts) -> Facts:
        """The facts without lines and messages of before."""
        if self._judged_s == -math.inf:
            return facts
        lines, messages = self._lines(facts.lines), self._messages(facts.messages)
        return replace(facts, lines=lines, messages=messages)

    def _lines(self, lines: Iterable[LogLine]) -> tuple[LogLine, ...]:
        return tuple(line for line in lines if line.at_s >= self._judged_s)

    def _messages(self, messages: Iterable[ObservedMessage]) -> tuple[ObservedMessage, ...]:
        return tuple(
            one
            for one in messages
            if one.at_s > self._earlier_to_s or one.sent_s is None or one.sent_s >= self._judged_s
        )
