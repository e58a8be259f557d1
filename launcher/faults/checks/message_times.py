"""When messages of a topic were sent, and how old they were when they came."""

from __future__ import annotations

from collections import deque

from launcher.faults.watcher.story import Story, plausible_s
from launcher.smoke.expect.evaluator import NotYetError, TooExpensiveError
from launcher.smoke.expect.expectation import Expectation
from launcher.smoke.judges.common import condition_text, forget, judged
from launcher.smoke.observe.facts import Facts, ObservedMessage

KEEP = 4000
MOST_WAITING = 2000  # that are evaluated at once: in a flood, older ones are left out


class SentTimes:
    """Those of one expectation: the counted ones, or those that satisfy its conditions."""

    def __init__(self, expectation: Expectation) -> None:
        self._expectation = expectation
        self._topic = str(expectation.subject)
        self._has_conditions = bool(condition_text(expectation))
        self._waiting: deque[ObservedMessage] = deque(maxlen=MOST_WAITING)
        self.refusal: str | None = None  # why its conditions are not evaluated
        self._sent: deque[float] = deque(maxlen=KEEP)
        self._delays: deque[tuple[float, float]] = deque(maxlen=KEEP)

    def take(self, story: Story) -> bool:
        """Take what is new; whether it is known what has come so far."""
        if not self._has_conditions:
            return self.known_s(story) is not None
        watch = self._expectation.get("watch")
        fitting = story.fitting.setdefault(self._expectation.name, deque(maxlen=KEEP))
        if self.refusal is not None:
            return True
        self._waiting += Facts(messages=story.facts.messages).received(self._topic, watch)
        if not self._waiting:
            return story.now_s > 0
        try:
            contents = [message.content for message in self._waiting]
            results = judged(self._expectation, contents)
        except NotYetError:
            return False
        except TooExpensiveError as error:
            self.refusal = str(error)
            return True
        for message, (fits, _) in zip(self._waiting, results, strict=True):
            if fits:
                self._note(message)
                fitting.append(message.at_s)
        self._waiting.clear()
        forget(self._expectation, contents)
        return True

    def known_s(self, story: Story) -> float | None:
        """Until when it is known what has come: the probe may be late on a busy machine."""
        if self._has_conditions:
            return story.now_s
        is_known = not story.is_blind and self._topic in story.arrivals
        return story.arrivals_s if is_known else None

    def _note(self, message: ObservedMessage) -> None:
        sent_s = plausible_s(message.sent_s, message.at_s)
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
