"""What makes the flight recorder write a snapshot, and how that is called."""

from __future__ import annotations

import json
import os
import queue
from pathlib import Path
from typing import Any

import pytest

from launcher.bag.ros import flight
from launcher.base.model.fault_events import FaultConfirmed, FaultHealed
from launcher.base.model.run_event import Entry
from launcher.base.model.run_events import Ended


class Following:
    """The connection to a run with these events."""

    def __init__(self, entries: list[Entry]) -> None:
        self._items = [one.item for one in entries]

    def __enter__(self) -> Following:
        return self

    def __exit__(self, *exc: object) -> None:
        pass

    def follow(self, verb: str) -> list[dict[str, Any]]:
        return self._items


def recorder_of(monkeypatch: pytest.MonkeyPatch, *entries: Entry) -> flight.FlightRecorder:
    """One that has read these events, without a ROS graph."""
    monkeypatch.setattr(flight, "Connection", lambda socket: Following(list(entries)))
    recorder = object.__new__(flight.FlightRecorder)
    recorder._settings = flight.FlightSettings(run_folder="", socket="")
    recorder._requests = queue.SimpleQueue()
    recorder._due, recorder._last_automatic_s = None, 100.0
    recorder._follow_events()
    recorder._take_requests(102.0)
    return recorder


FAULT = Entry(1.0, 1.0, FaultConfirmed("robot_1 reports", "nothing for 2 s", 1, "it hangs"))
FOLLOWER = Entry(1.0, 1.0, FaultConfirmed("map", "old", 1, None, "robot_1 reports"))
HEALED = Entry(1.0, 1.0, FaultHealed("robot_1 reports", 2.0, 1))
DEATH = Entry(1.0, 1.0, Ended(7, -9, False, None), "a-1")


def test_a_fault_is_a_reason_for_a_snapshot(monkeypatch: pytest.MonkeyPatch):
    due = recorder_of(monkeypatch, HEALED, FAULT, FOLLOWER, FAULT)._due

    assert due is not None
    assert due.reasons == ["fault 'robot_1 reports': nothing for 2 s; it hangs"]
    assert (due.kind, due.at_s) == ("fault", 100.0 + flight.APART_S)


def test_what_follows_from_another_fault_is_none(monkeypatch: pytest.MonkeyPatch):
    assert recorder_of(monkeypatch, FOLLOWER, HEALED)._due is None


def test_a_death_and_its_fault_share_a_snapshot(monkeypatch: pytest.MonkeyPatch):
    due = recorder_of(monkeypatch, FAULT, DEATH)._due

    assert due is not None and due.kind == "death" and len(due.reasons) == 2


def test_the_oldest_snapshots_of_faults_are_removed(tmp_path: Path):
    for number in range(10, 10 + flight.KEEP_SNAPSHOTS):
        for kind in ("death", "fault", "asked"):
            (tmp_path / f"2026-{number}-{kind}").mkdir()
    flight._prune(str(tmp_path))

    left = sorted(os.listdir(tmp_path))
    assert sum(name.endswith("-asked") for name in left) == flight.KEEP_SNAPSHOTS
    assert sum(not name.endswith("-asked") for name in left) == flight.KEEP_SNAPSHOTS


@pytest.mark.parametrize("first", ["action", "fault"])
def test_an_action_of_a_fault_gets_the_snapshot_of_that_fault(
    monkeypatch: pytest.MonkeyPatch, first: str
):
    recorder = recorder_of(monkeypatch, *([FAULT] if first == "fault" else []))
    order = {"snapshot": FAULT.event.text, "id": 7, "of_fault": True}
    monkeypatch.setattr("sys.stdin", [json.dumps(order), json.dumps({"end": True})])
    recorder._read_orders()
    if first == "action":
        monkeypatch.setattr(flight, "Connection", lambda socket: Following([FAULT]))
        recorder._follow_events()
    recorder._take_requests(102.0)

    due = recorder._due
    assert due is not None and (due.kind, due.asked) == ("fault", [7])
    assert due.reasons == [FAULT.event.text]
    assert due.at_s == 102.0 + flight.AFTER_S
