"""Rates, gaps and latencies of topics, over the last seconds."""

from __future__ import annotations

import itertools
import statistics
from collections import deque
from dataclasses import replace

from launcher.base.document.quantities import NumberRange, seconds_text
from launcher.faults.checks.check import ExpectationCheck
from launcher.faults.model.fault import Finding
from launcher.faults.model.fault_life import Debounce
from launcher.faults.watcher.story import Story
from launcher.smoke.expect.evaluator import EVALUATOR, NotYetError, TooExpensiveError
from launcher.smoke.expect.expectation import START, Expectation
from launcher.smoke.judges import judge
from launcher.smoke.judges.common import condition_text, judged
from launcher.smoke.observe.facts import Facts, ObservedMessage

SHORTEST_S = 2.0  # window of a rate
MESSAGES = 10  # at the lowest rate, that a window has
SILENT_PERIODS = 3  # of the lowest rate: then the topic is silent, whatever the window says
SHORTEST_SILENCE_S = 1.0
DELAYS_S = 3.0  # window of a latency
LEAST_DELAYS = 5
HIGH = 0.95  # this part of the messages is in time
# A window of few messages that is off by one of them says nothing.
_SLACK_MESSAGES = 1.0


class TrafficCheck(ExpectationCheck):
    """What is known of one topic's messages."""

    def __init__(self, expectation: Expectation, expected: str) -> None:
        super().__init__(expectation, expected)
        self.topic = str(expectation.subject)

    def found(self, story: Story, seen: str, **more: object) -> Finding:
        nodes = story.publishers(self.topic)
        return Finding(
            seen=seen,
            nodes=nodes,
            topics=(self.topic,),
            processes=story.processes_of(nodes),
            **more,  # type: ignore[arg-type]
        )

    def has_been_silent(self, story: Story, limit_s: float, last_s: float | None) -> float | None:
        """How long nothing has come, if that is longer than the limit."""
        if last_s is None:
            return story.now_s if story.now_s > self.grace_s else None
        silent_s = story.now_s - last_s
        return silent_s if silent_s > limit_s else None


class RateCheck(TrafficCheck):
    """The rate in a window that has some messages, and silence before the window is over."""

    debounce = Debounce(confirm_s=0.7, heal_s=2.0)

    def __init__(self, expectation: Expectation) -> None:
        now = replace(expectation, within=None, after=START)
        super().__init__(expectation, judge(now, Facts()).expected)
        self._span: NumberRange = expectation.get("is")
        low = self._span.low
        self.window_s = SHORTEST_S if low <= 0 else max(SHORTEST_S, MESSAGES / low)
        self._has_conditions = bool(condition_text(expectation))
        self._waiting: list[ObservedMessage] = []
        self._times: deque[float] = deque(maxlen=4000)  # of messages that satisfy the conditions
        self._since_s: float | None = None

    def judge(self, story: Story) -> tuple[bool, Finding | None]:
        from_s = story.now_s - self.window_s
        times = self._conditioned(story, from_s) if self._has_conditions else _sent(story, self)
        if times is None:
            return False, None
        if self._since_s is None and times:
            self._since_s = times[0]
        last_s = times[-1] if times else self._last_s(story)
        low = self._span.low
        if low > 0:
            limit_s = max(SHORTEST_SILENCE_S, SILENT_PERIODS / low)
            silent_s = self.has_been_silent(story, limit_s, last_s)
            if silent_s is not None:
                seen = "no message" if last_s is None else f"silent for {seconds_text(silent_s)}"
                return True, self.found(story, seen, value=0.0, unit="Hz", since_s=last_s)
        if self._since_s is None or self._since_s > from_s:
            return low <= 0 and self._since_s is None, None  # the window is not full yet
        return True, self._off(story, times)

    def _off(self, story: Story, times: list[float]) -> Finding | None:
        """The rate between the first and the last message of the window, if it is wrong."""
        span = self._span
        if len(times) < 2:
            return None
        elapsed_s = max(times[-1] - times[0], 1e-9)
        rate_hz = (len(times) - 1) / elapsed_s
        slack_hz = _SLACK_MESSAGES / self.window_s
        if span.low - slack_hz <= rate_hz <= span.high + slack_hz:
            return None
        seen = f"{rate_hz:.3g} Hz in the last {self.window_s:.3g} s"
        return self.found(story, seen, value=rate_hz, unit="Hz")

    def _last_s(self, story: Story) -> float | None:
        if self._has_conditions:
            return self._times[-1] if self._times else None
        arrivals = story.arrivals.get(self.topic)
        return arrivals.sent[-1] if arrivals is not None and arrivals.sent else None

    def _conditioned(self, story: Story, from_s: float) -> list[float] | None:
        """The times of those that satisfy the conditions; None while they are evaluated."""
        watch = self.expectation.get("watch")
        self._waiting += Facts(messages=story.facts.messages).received(self.topic, watch)
        if self._waiting:
            try:
                results = judged(self.expectation, [m.content for m in self._waiting])
            except NotYetError:
                return None
            except TooExpensiveError:
                self._waiting = []
                return None
            for message, (fits, _) in zip(self._waiting, results, strict=True):
                if fits:
                    at_s = message.at_s if message.sent_s is None else message.sent_s
                    self._times.append(at_s)
            self._waiting = []
            EVALUATOR.forget()
        return sorted(at_s for at_s in self._times if at_s >= from_s)


def _sent(story: Story, check: RateCheck) -> list[float] | None:
    arrivals = story.arrivals.get(check.topic)
    if arrivals is None:
        return None  # the probe has not answered yet
    return arrivals.sent_since(story.now_s - check.window_s)


class GapCheck(TrafficCheck):
    """No pause between two messages is longer, nor the one that goes on."""

    debounce = Debounce(confirm_s=0.0, heal_s=3.0)

    def __init__(self, expectation: Expectation) -> None:
        self._limit_s = float(expectation.get("below"))
        text = f"pauses between messages on {expectation.subject}"
        super().__init__(expectation, f"{text} are below {seconds_text(self._limit_s)}")
        self._last_s: float | None = None

    def judge(self, story: Story) -> tuple[bool, Finding | None]:
        arrivals = story.arrivals.get(self.topic)
        if arrivals is None:
            return False, None
        before_s = self._last_s
        times = arrivals.sent_since(-1.0 if before_s is None else before_s)
        longest_s = max((b - a for a, b in itertools.pairwise(times)), default=0.0)
        if times:
            self._last_s = times[-1]
        silent_s = self.has_been_silent(story, self._limit_s, self._last_s)
        pause_s = max(longest_s, silent_s or 0.0)
        if pause_s <= self._limit_s:
            return self._last_s is not None, None
        since_s = story.now_s - silent_s if silent_s else None
        seen = f"a pause of {seconds_text(pause_s)}"
        seen = f"silent for {seconds_text(silent_s)}" if silent_s else seen
        return True, self.found(story, seen, value=pause_s, unit="s", since_s=since_s, certain=True)


class LatencyCheck(TrafficCheck):
    """Most messages of the last seconds were received in time after their stamps."""

    debounce = Debounce(confirm_s=0.7, heal_s=3.0)

    def __init__(self, expectation: Expectation) -> None:
        self._limit_s = float(expectation.get("below"))
        text = f"{HIGH:.0%} of the messages on {expectation.subject} arrive"
        super().__init__(expectation, f"{text} within {seconds_text(self._limit_s)}")

    def judge(self, story: Story) -> tuple[bool, Finding | None]:
        arrivals = story.arrivals.get(self.topic)
        delays = [] if arrivals is None else arrivals.delays_since(story.now_s - DELAYS_S)
        if len(delays) < LEAST_DELAYS:
            return False, None
        high_s = statistics.quantiles(delays, n=20, method="inclusive")[-1]
        if high_s <= self._limit_s:
            return True, None
        seen = f"{seconds_text(high_s)} in the last {DELAYS_S:g} s"
        return True, self.found(story, seen, value=high_s, unit="s")
