"""Messages of the topics that expectations are about, counted or received by the probe."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from typing import Any

from launcher.base.errors import LauncherError
from launcher.faults.watcher.observations import Observations
from launcher.faults.watcher.story import Story, TopicArrivals
from launcher.smoke.expect.expectation import Expectation
from launcher.smoke.observe.probe_client import ProbeClient
from launcher.smoke.run.probe_requests import subscribed

POLL_S = 0.5
# The middleware stamps messages, and what ends is reported by the launcher: both can wait.
LISTEN_S = 0.25
GRAPH_S = 0.5
ANSWER_S = 5.0
IDLE_S = 5.0  # between two requests if no topic is counted
MOST_UNANSWERED = 6  # requests: the probe hangs, and is ended
_COUNTED = ("rate", "gap", "latency")


def _is_counted(one: Expectation) -> bool:
    """Whether the times of its messages are enough."""
    return one.kind in _COUNTED and not (one.get("where") or one.get("fields"))


class TopicWatch:
    """Polls the probe in a thread; `merge` adds what has come to the story.

    A probe that hangs is ended: the watcher starts another one. `expectations` are those
    given, with the subscriptions that they need.
    """

    def __init__(
        self, probe: ProbeClient, observations: Observations, expectations: Iterable[Expectation]
    ) -> None:
        self._probe = probe
        self._observations = observations
        given = [*expectations]
        probe.send("listen", period_s=LISTEN_S, graph_s=GRAPH_S)
        rest = iter([*subscribed(probe, (one for one in given if not _is_counted(one)))])
        self.expectations = [one if _is_counted(one) else next(rest) for one in given]
        self._topics = self._subscribe([one for one in given if _is_counted(one)])
        self._lock = threading.Lock()
        self._new: list[tuple[dict[str, Any], float, float]] = []
        self._is_over = threading.Event()
        threading.Thread(target=self._poll, daemon=True, name="arrivals").start()

    def _subscribe(self, counted: Iterable[Expectation]) -> dict[str, str]:
        """Subscription -> topic."""
        types: dict[str, str | None] = {}
        for one in counted:
            topic = str(one.subject)
            types[topic] = types.get(topic) or one.get("type")
        found = {}
        for topic, type_ in types.items():
            key = f"count {topic}"
            self._probe.send(
                "subscribe", sub=key, topic=topic, type=type_, qos=None, messages=False, stamps=True
            )
            found[key] = topic
        return found

    def _poll(self) -> None:
        period_s, unanswered = POLL_S if self._topics else IDLE_S, 0
        while not self._is_over.wait(period_s) and self._probe.is_alive:
            asked_s = self._observations.now_s
            try:
                subs = self._probe.ask("arrivals", timeout_s=ANSWER_S, silent=False)["subs"]
            except LauncherError:
                unanswered += 1
                if unanswered == MOST_UNANSWERED:
                    self._probe.close()
                continue
            unanswered = 0
            # Both clocks now, as long as they fit the stamps.
            offset_s = self._observations.wall_of(0.0)
            with self._lock:
                self._new.append((subs, offset_s, asked_s))

    def merge(self, story: Story) -> None:
        """Add what has come since the last call."""
        with self._lock:
            new, self._new = self._new, []
        for subs, offset_s, asked_s in new:
            story.arrivals_s = asked_s
            for key, topic in self._topics.items():
                known = story.arrivals.setdefault(topic, TopicArrivals())
                if key in subs:
                    self._add(known, subs[key], offset_s)

    def _add(self, known: TopicArrivals, one: dict[str, Any], offset_s: float) -> None:
        start_s = self._observations.of_monotonic(0.0)
        received = [at_s + start_s for at_s in one["mono"]]
        known.add(received, [sent_s - offset_s for sent_s in one["sent"]])
        stamps = one.get("stamp") or one["sent"]
        known.delays += [
            (at_s, at_s - stamp_s + offset_s)
            for at_s, stamp_s in zip(received, stamps, strict=True)
            if stamp_s is not None
        ]

    def close(self) -> None:
        self._is_over.set()
