"""Figures of incidents: whose they are, what they are called, and from which time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from launcher.bag import snapshot_folder
from launcher.bag.snapshot_folder import SnapshotContents
from launcher.base.model.record import replace as changed
from launcher.base.model.run_event import Entry
from launcher.base.model.run_events import Sample
from launcher.faults.incident import document, from_snapshot, page
from launcher.faults.incident.completion import completed
from launcher.faults.incident.document import IncidentDocument
from launcher.faults.incident.parts.happenings import happenings
from launcher.faults.incident.run_folder import RunFolder
from launcher.faults.watcher.incident_files import IncidentFiles
from launcher.smoke.observe.facts import ObservedMessage
from tests.faults.unit.watched import LISTENER, MIB, PAIR, TALKER, WatchedRun
from tests.support.incidents import OPENED_S, fault, incident_document
from tests.support.run_events import event, line, variants

WALL_S = OPENED_S  # of the start of the run
SAMPLE = next(variants(Sample))


def written(run: WatchedRun) -> IncidentDocument:
    """The newest incident as its file has it."""
    files = IncidentFiles(None, {}, lambda at_s: WALL_S + at_s, print)
    return document.from_value(files.document(run.incidents[-1], run.story))


def page_of(incident: IncidentDocument) -> str:
    """Without drawings, which take seconds."""
    return str(page.render(replace(incident, graphs={}), None))


def talking(*entries: str) -> WatchedRun:
    run = WatchedRun(*entries)
    run.rows(TALKER, LISTENER)
    run.graph(*PAIR)
    return run


# ---- memory


def of_a_watched_run(folder: Path) -> IncidentDocument:
    run = WatchedRun("memory: talker, below: 100 MB")
    for _ in range(5):
        run.rows({**TALKER, "rss_bytes": 180 * MIB, "uss_bytes": 150 * MIB})
        run.wait(1)
    return written(run)


def of_an_event_log(folder: Path) -> IncidentDocument:
    given = document.from_value(incident_document(processes={}))
    return completed(given, RunFolder(str(folder)))


def of_a_snapshot(folder: Path) -> IncidentDocument:
    return document.from_value(snapshot_of(folder))


@pytest.mark.parametrize("made", [of_a_watched_run, of_an_event_log, of_a_snapshot])
def test_memory_is_what_it_is_called(made: Callable[[Path], IncidentDocument], tmp_path: Path):
    sample = changed(SAMPLE, rss_bytes=180 * MIB, uss_bytes=150 * MIB)
    found = [
        Entry(OPENED_S - 1, 1.0, event("resources", processes={"robot_1-3": sample}), None),
        Entry(OPENED_S, 2.0, event("ended", returncode=-9, asked=False), "robot_1-3"),
    ]
    (tmp_path / "events.jsonl").write_text("".join(f"{line(one)}\n" for one in found))

    incident = made(tmp_path)

    (samples,) = incident.processes.values()
    assert samples[-1][2] == 180 * MIB
    text = page_of(incident)
    assert "(RSS)" in text and "USS" not in text


def snapshot_of(folder: Path) -> dict[str, Any]:
    contents = SnapshotContents(
        reason="robot_1-3 died (SIGKILL)",
        end_ns=int((OPENED_S + 1) * 1e9),
        keep_s=30.0,
        topics=[],
        messages=[],
        nodes={},
        run_folder=str(folder),
    )
    snapshot_folder.write(str(folder / "snapshot"), contents)
    return from_snapshot.document_of(str(folder / "snapshot"))


# ---- topics


def receive(run: WatchedRun, seconds: int, *values: int) -> None:
    """Each value in each second, by two subscriptions of the topic."""
    for _ in range(seconds):
        run.look(
            messages=tuple(
                ObservedMessage(at_s=run.now_s, topic="/t", content={"data": value}, watch=watch)
                for value in values
                for watch in ("a", "b")
            )
        )
        run.wait(0.8)


def test_messages_with_conditions_are_shown_beside_all_of_the_topic():
    run = talking("rate: /t, is: '>= 0.5 Hz', fields: {data: 2}, name: two reports")
    receive(run, 20, 1, 2)
    silent_s = WALL_S + run.now_s
    receive(run, 15, 1)

    topic = written(run).topics["/t"]

    assert len(topic.arrivals) == 55
    assert len(topic.fitting["two reports"]) == 40
    assert max(topic.fitting["two reports"]) < silent_s
    text = page_of(written(run))
    assert "two reports: 40 messages" in text and "all messages: 55 messages" in text


def test_a_topic_that_nobody_has_looked_at_is_not_silent():
    run = talking("topic: /t")
    run.wait(1)
    run.graph()
    run.wait(3)

    text = page_of(written(run))

    assert "When messages came was not watched." in text
    assert "No message was received" not in text


# ---- the timeline


@pytest.mark.parametrize("is_logged", [True, False])
def test_the_timeline_has_what_was_seen_at_its_time(is_logged: bool):
    silent = fault("reports", seen="silent for 26.4 s", confirmed_s=OPENED_S + 3.5)
    logged = [
        {"wall_s": OPENED_S + at_s, "event": "fault", "fault": "reports", "seen": seen}
        for at_s, seen in ((-60, "silent for 9 s"), (4.2, "silent for 3.4 s"))
    ]
    given = incident_document(
        faults=[silent],
        causes=[],
        events=[{**one, "incident": 3} for one in logged] if is_logged else [],
    )

    found = [one.text for one in happenings(document.from_value(given))]

    confirmed = "confirmed: silent for 3.4 s" if is_logged else "confirmed"
    assert found == ["first seen", confirmed, "healed"]
