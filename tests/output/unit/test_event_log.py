"""What of the events of a run stays in memory."""

from __future__ import annotations

import json

from launcher.base.model.run_events import Asked, Resources, SnapshotWritten
from launcher.output.logs.event_log import RECENT, RECENT_BYTES, EventLog


def history(log: EventLog) -> list[str]:
    return [json.loads(line)["process"] for line in log.history()]


def test_the_oldest_entries_are_forgotten():
    written: list[bytes] = []
    log = EventLog(written.append)
    for number in range(RECENT + 5):
        log.note(Asked(verb="stop"), process=f"p{number}")
    assert history(log) == [f"p{number}" for number in range(5, RECENT + 5)]
    assert b"".join(written).count(b"\n") == RECENT + 5


def test_long_entries_are_forgotten_sooner():
    log = EventLog(lambda lines: None)
    long = "x" * (RECENT_BYTES // 20)
    for number in range(100):
        log.note(SnapshotWritten(path="/p", reason=long), process=f"p{number}")
    assert 10 < len(history(log)) < 20
    assert history(log)[-1] == "p99"
    log.note(SnapshotWritten(path="/p", reason=20 * long), process="last")
    assert history(log) == []


def test_of_samples_of_resources_only_the_newest_is_kept():
    log = EventLog(lambda lines: None)
    for number in range(3):
        log.note(Resources(processes={}), process=f"p{number}")
        log.flush()
    assert history(log) == ["p2"]
