"""Rates, gaps and latencies of topics, over the last seconds."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

from launcher.base.document.quantities import NumberRange, seconds_text
from launcher.faults.checks.check import ExpectationCheck
from launcher.faults.checks.message_times import SentTimes
from launcher.faults.model.fault import FaultFinding
from launcher.faults.model.fault_life import Debounce
from launcher.faults.watcher.story import Story
from launcher.smoke.expect.expectation import START, Expectation
from launcher.smoke.judges import judge
from launcher.smoke.judges.time_series import LATENCY_SHARE, latency_s
from launcher.smoke.judges.timeliness import duration_text
from launcher.smoke.observe.facts import Facts

SHORTEST_S = 2.0  # window of a rate
MESSAGES = 10  # at the lowest rate, that a window has
SLACK_MESSAGES = 1.0  # a window that is off by one of them says nothing
SILENT_PERIODS = 3  # of the lowest rate: then the topic is silent, whatever the window says
SHORTEST_SILENCE_S = 1.0
DELAYS_S = 3.0  # window of a latency
LEAST_DELAYS = 5


class TrafficCheck(ExpectationCheck):
    """What is known of one topic's messages."""

    def __init__(self, expectation: Expectation) -> None:
        now = replace(expectation, within=None, after=START)
        super().__init__(expectation, judge(now, Facts()).expected)
        self.topic = str(expectation.subject)
        self.times = SentTimes(expectation)
        self._known_s: float | None = None  # until when arrivals were known at the last look
        self._last: tuple[bool, FaultFinding | None] = (False, None)

    def judge(self, story: Story) -> tuple[bool, FaultFinding | None]:
        known_s = self.times.known_s(story)
        if known_s != self._known_s:  # else nothing can have changed
            self._known_s = known_s
            self._last = self._judged(story, known_s)
        return self._last

    def _judged(self, story: Story, known_s: float | None) -> tuple[bool, FaultFinding | None]:
        if known_s is None or not self.times.take(story):
            return False, None
        if self.times.refusal is not None:
            return True, self.found(story, self.times.refusal)
        return self.judged(story, known_s)

    def judged(self, story: Story, known_s: float) -> tuple[bool, FaultFinding | None]:
        """As `judge`, with what has come until `known_s`."""
        raise NotImplementedError

    def found(self, story: Story, seen: str, **more: Any) -> FaultFinding:
        nodes = story.publishers(self.topic)
        processes = story.processes_of(nodes)
        return FaultFinding(
            seen=seen, nodes=nodes, topics=(self.topic,), processes=processes, **more
        )

    def silence(self, story: Story, known_s: float, limit_s: float) -> FaultFinding | None:
        """That nothing has come for longer than this."""
        last_s = self.times.last_s(story)
        if last_s is None:
            return self.found(story, "no message", value=0.0, unit="Hz")
        silent_s = known_s - last_s
        if silent_s <= limit_s:
            return None
        seen = f"silent for {seconds_text(silent_s)}"
        return self.found(story, seen, value=0.0, unit="Hz", since_s=last_s, lack=1.0)


class RateCheck(TrafficCheck):
    """The rate in a window that has some messages, and silence before the window is over."""

    debounce = Debounce(confirm_s=0.7, heal_s=2.0)

    def __init__(self, expectation: Expectation) -> None:
        super().__init__(expectation)
        self._span: NumberRange = expectation.get("is")
        low = self._span.low
        self.window_s = SHORTEST_S if low <= 0 else max(SHORTEST_S, MESSAGES / low)
        self._since_s: float | None = None  # from when on its messages are known

    def judged(self, story: Story, known_s: float) -> tuple[bool, FaultFinding | None]:
        from_s, low = known_s - self.window_s, self._span.low
        times = self.times.sent_since(story, from_s)
        if self._since_s is None and times:
            self._since_s = times[0]
        if low > 0:
            limit_s = max(SHORTEST_SILENCE_S, SILENT_PERIODS / low)
            if (finding := self.silence(story, known_s, limit_s)) is not None:
                return True, finding
        if self._since_s is None or self._since_s > from_s:
            return False, None  # the window is not full yet
        return True, self._off(story, times)

    def _off(self, story: Story, times: list[float]) -> FaultFinding | None:
        """The rate of the window, if it is wrong.

        It is that between the first and the last message, or that of all: the first is right for
        few messages, the second for such that come in bursts.
        """
        span = self._span
        if len(times) < 2:
            return None
        rate_hz = (len(times) - 1) / max(times[-1] - times[0], 1e-9)
        slack_hz = SLACK_MESSAGES / self.window_s
        low_hz, high_hz = sorted((rate_hz, len(times) / self.window_s))
        if high_hz >= span.low - slack_hz and low_hz <= span.high + slack_hz:
            return None
        seen = f"{rate_hz:.3g} Hz in the last {self.window_s:.3g} s"
        lack = max(0.0, 1.0 - rate_hz / span.low) if span.low > 0 else 0.0
        return self.found(story, seen, value=rate_hz, unit="Hz", lack=lack)


class GapCheck(TrafficCheck):
    """No pause between two messages is longer, nor the one that goes on."""

    debounce = Debounce(confirm_s=0.0, heal_s=3.0)

    def __init__(self, expectation: Expectation) -> None:
        super().__init__(expectation)
        self._limit_s = float(expectation.get("below"))
        self._last_s: float | None = None

    def judged(self, story: Story, known_s: float) -> tuple[bool, FaultFinding | None]:
        last_s = self._last_s
        times = self.times.sent_since(story, 0.0 if last_s is None else last_s)
        self._last_s = times[-1] if times else last_s
        finding = self.silence(story, known_s, self._limit_s)
        if finding is not None:
            silent_s = None if self._last_s is None else known_s - self._last_s
            is_certain = finding.since_s is not None
            return True, replace(finding, certain=is_certain, value=silent_s, unit="s")
        longest_s = max((b - a for a, b in itertools.pairwise(times)), default=0.0)
        if longest_s <= self._limit_s:
            return True, None
        seen = f"a pause of {seconds_text(longest_s)}"
        return True, self.found(story, seen, value=longest_s, unit="s", certain=True)


class LatencyCheck(TrafficCheck):
    """Most messages of the last seconds were received in time after their stamps."""

    debounce = Debounce(confirm_s=0.7, heal_s=3.0)

    def judged(self, story: Story, known_s: float) -> tuple[bool, FaultFinding | None]:
        delays = self.times.delays_since(story, known_s - DELAYS_S)
        if len(delays) < LEAST_DELAYS:
            return False, None
        high_s, limit_s = latency_s(delays), float(self.expectation.get("below"))
        if high_s < limit_s:
            return True, None
        seen = f"{duration_text(round(high_s, 3))} in {LATENCY_SHARE:.0%} of {len(delays)} messages"
        return True, self.found(story, seen, value=high_s, unit="s")
