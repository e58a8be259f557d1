"""When messages of a topic were sent, and how old they were when they came."""

from __future__ import annotations

from collections import deque

from launcher.faults.watcher.story import Story
from launcher.smoke.expect.evaluator import EVALUATOR, NotYetError, TooExpensiveError
from launcher.smoke.expect.expectation import Expectation
from launcher.smoke.judges.common import condition_text, judged
from launcher.smoke.observe.facts import Facts, ObservedMessage

KEEP = 4000


class MessageTimes:
    """Those of one expectation: the counted ones, or those that satisfy its conditions."""

    def __init__(self, expectation: Expectation) -> None:
        self._expectation = expectation
        self._topic = str(expectation.subject)
        self._has_conditions = bool(condition_text(expectation))
        self._waiting: list[ObservedMessage] = []
        self._sent: deque[float] = deque(maxlen=KEEP)
        self._delays: deque[tuple[float, float]] = deque(maxlen=KEEP)

    def take(self, story: Story) -> bool:
        """Take what is new; whether it is known what has come so far."""
        if not self._has_conditions:
            return self._topic in story.arrivals
        watch = self._expectation.get("watch")
        self._waiting += Facts(messages=story.facts.messages).received(self._topic, watch)
        if not self._waiting:
            return story.now_s > 0
        try:
            results = judged(self._expectation, [m.content for m in self._waiting])
        except NotYetError:
            return False
        except TooExpensiveError:
            self._waiting = []
            return False
        for message, (fits, _) in zip(self._waiting, results, strict=True):
            if fits:
                self._note(message)
        self._waiting = []
        EVALUATOR.forget()
        return True

    def _note(self, message: ObservedMessage) -> None:
        sent_s = message.at_s if message.sent_s is None else message.sent_s
        begin_s = sent_s if message.stamp_s is None else message.stamp_s
        self._sent.append(sent_s)
        self._delays.append((message.at_s, message.at_s - begin_s))

    def sent_since(self, story: Story, from_s: float) -> list[float]:
        """Sorted, from this time on."""
        if self._has_conditions:
            return sorted(at_s for at_s in self._sent if at_s >= from_s)
        return story.arrivals[self._topic].sent_since(from_s)

    def delays_since(self, story: Story, from_s: float) -> list[float]:
        if self._has_conditions:
            return [delay_s for at_s, delay_s in self._delays if at_s >= from_s]
        return story.arrivals[self._topic].delays_since(from_s)

    def last_s(self, story: Story) -> float | None:
        """When the last one was sent; None if none has come."""
        sent = self._sent if self._has_conditions else story.arrivals[self._topic].sent
        return sent[-1] if sent else None
