"""What a new watcher, or a new probe, finds of the time before."""

from __future__ import annotations

import queue
from typing import Any

from launcher.faults.watcher.handover import EARLIER_S, OPEN_S, Handover
from launcher.faults.watcher.watching import FaultWatcher, WatchSettings
from launcher.smoke.observe.facts import Facts, LogLine, ObservedMessage

OLD_S, NEW_S = -60.0, -0.5  # the new watcher begins at 0


def line(at_s: float) -> LogLine:
    return LogLine(at_s=at_s, process="cat-1", text="[ERROR] x", stream="stdout")


def message(at_s: float, sent_s: float | None) -> ObservedMessage:
    return ObservedMessage(at_s=at_s, topic="/t", content={}, sent_s=sent_s)


def test_a_new_watcher_judges_what_came_after_the_last_report():
    handover, before = Handover(), message(1.0, OLD_S)
    given = Facts(lines=(line(OLD_S), line(NEW_S)), messages=(before, message(1.0, NEW_S)))
    assert handover.unjudged(given) is given  # the first watcher of a run

    handover.resume(-2.0)
    handover.subscribe(0.0)
    found = handover.unjudged(given)
    assert [one.at_s for one in found.lines] == [NEW_S]
    assert [one.sent_s for one in found.messages] == [NEW_S]
    assert handover.unjudged(Facts(lines=(line(-2.0 - OPEN_S),))).lines  # may wait for its cause


def test_later_messages_of_a_clock_that_is_behind_are_judged():
    handover = Handover()
    handover.resume(-2.0)
    handover.subscribe(0.0)
    found = handover.unjudged(Facts(messages=(message(EARLIER_S + 0.1, OLD_S), message(1.0, None))))
    assert len(found.messages) == 2


def begun(written_s: float | None) -> FaultWatcher:
    """A watcher that looks for the first time."""
    requests: queue.SimpleQueue[Any] = queue.SimpleQueue()
    settings = WatchSettings(socket="", run_folder=None, launch_file="x.launch.py")
    watcher = FaultWatcher(settings, requests, lambda **report: None)
    watcher._observations.begin()
    watcher._begin_history({"run": {"id": "1"}, "launcher": "1", "ros": None})
    if written_s is not None:
        watcher._handover.resume(written_s)
    return watcher


def test_lines_of_before_are_known_and_not_judged():
    for written_s, judged in ((None, [OLD_S, NEW_S]), (-2.0, [NEW_S])):
        watcher = begun(written_s)
        for at_s in (OLD_S, NEW_S):
            watcher._observations.add(line(at_s))
        watcher._look()
        assert [one.at_s for one in watcher._story.facts.lines] == judged
        assert len(watcher._story.last_lines(["cat-1"])) == 2
