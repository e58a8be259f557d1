"""The timeline of a start-up, by the events of a run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.base.errors import UsageError
from launcher.base.model.run_event import Entry
from launcher.launch.analyze.timeline import critical_chain, read, timeline
from launcher.launch.analyze.timeline_report import document, lines
from tests.support import run_events
from tests.support.run_events import T0


def event(at_s: float, kind: str, process: str, **details: Any) -> Entry:
    return run_events.entry(run_events.event(kind, **details), at_s, process)


FLEET = [
    event(0.0, "started", "dispatcher-1", pid=1, ready_when=("x",)),
    event(0.0, "waiting", "robot_1-2", after=("dispatcher",)),
    event(
        0.1,
        "waiting",
        "robot_2-3",
        after=(
            "dispatcher",
            "robot_1",
        ),
    ),
    event(0.2, "started", "monitor-4", pid=2),
    event(1.0, "ready", "dispatcher-1"),
    event(1.0, "released", "robot_1-2", why="ready", processes=("dispatcher-1",)),
    event(1.1, "started", "robot_1-2", pid=3, ready_when=("x",)),
    event(3.1, "ready", "robot_1-2"),
    event(
        3.1,
        "released",
        "robot_2-3",
        why="ready",
        processes=(
            "dispatcher-1",
            "robot_1-2",
        ),
    ),
    event(3.2, "started", "robot_2-3", pid=4),
    event(4.0, "ended", "robot_1-2"),
    event(4.1, "started", "robot_1-2", pid=5, ready_when=("x",)),
    event(9.0, "ready", "robot_1-2"),
]


def test_the_first_start_of_each_process_counts():
    found = timeline("x", FLEET).processes
    assert list(found) == ["dispatcher-1", "robot_1-2", "robot_2-3", "monitor-4"]
    robot = found["robot_1-2"]
    times = (robot.queued_s, robot.released_s, robot.started_s, robot.ready_s)
    assert times == pytest.approx((0.0, 1.0, 1.1, 3.1))
    assert (robot.own_s, robot.waited_s) == pytest.approx((2.0, 1.0))
    assert found["monitor-4"].done_s == found["monitor-4"].started_s == pytest.approx(0.2)


def test_the_critical_chain_goes_back_from_the_last_that_was_ready():
    chain = critical_chain(timeline("x", FLEET))
    assert [one.name for one in chain] == ["robot_2-3", "robot_1-2", "dispatcher-1"]


def test_a_wait_that_ended_by_its_timeout_is_no_cause():
    late = [
        event(0.0, "started", "a-1"),
        event(0.0, "waiting", "b-2"),
        event(5.0, "released", "b-2", why="timeout", processes=("a-1",)),
        event(5.0, "started", "b-2"),
    ]
    assert [one.name for one in critical_chain(timeline("x", late))] == ["b-2"]


def test_the_report_has_timeline_slowest_and_chain():
    text = "\n".join(lines(timeline("x", FLEET), 60))
    assert text.startswith("4 of 4 processes ready after 3.20 s, the first was asked for after 0")
    assert "    2.00 s  robot_1-2\n    1.00 s  dispatcher-1" in text
    assert (
        "robot_2-3 @3.20 s +0.00 s, waited 3.00 s\n"
        "`-robot_1-2 @3.10 s +2.00 s, waited 1.00 s\n"
        "  `-dispatcher-1 @1.00 s +1.00 s\n"
        "    `-launch file @0.00 s"
    ) in text
    assert "nothing says when" not in text


def test_bars_show_waits_and_starts_in_proportion():
    report = lines(timeline("x", FLEET), 112)
    row = next(line for line in report if line.startswith("robot_1-2"))
    bar = row[14 : row.index("|")]
    assert bar.count("=") == pytest.approx(2 * bar.count("."), abs=4)


def test_one_that_is_not_ready_is_told():
    some = timeline(
        "x",
        [
            event(0.0, "started", "a-1", ready_when=("x",)),
            event(0.5, "waiting", "b-2"),
            event(1.0, "started", "c-3", ready_when=("x",)),
            event(2.0, "ended", "c-3"),
        ],
    )
    report = lines(some, 80)
    assert "not ready: a-1 (running since 0.00 s)" in report
    assert "not ready: b-2 (waiting since 0.50 s)" in report
    assert "not ready: c-3 (it has ended at 2.00 s)" in report
    assert document(some)["is_ready"] is False


def test_without_facts_the_report_says_how_to_get_some():
    report = lines(timeline("x", [event(0.0, "started", "a-1")]), 80)
    assert "ready_when in NAME.supervise.yaml" in report[-1]


def test_the_document_has_all_times():
    found = document(timeline("x", FLEET))
    assert found["critical_chain"] == ["robot_2-3", "robot_1-2", "dispatcher-1"]
    assert found["processes"][1] == {
        "name": "robot_1-2",
        "queued_s": 0.0,
        "released_s": 1.0,
        "started_s": 1.1,
        "ready_s": 3.1,
        "ended_s": 4.0,
        "own_s": 2.0,
        "waited_for": ["dispatcher-1"],
        "why": "ready",
        "has_ready_when": True,
    }


def test_the_name_of_the_folder_says_when_the_launcher_began(tmp_path: Path):
    import time

    stamp = time.strftime("%Y-%m-%d-%H-%M-%S", time.localtime(int(T0)))
    folder = tmp_path / f"{stamp}-250000-host-7"
    folder.mkdir()
    text = run_events.line(event(1.0, "started", "a-1"))
    (folder / "events.jsonl").write_text(f'{text}\n{{"cut": sh\nnull\n', encoding="utf-8")
    assert read(str(folder)).processes["a-1"].started_s == pytest.approx(0.75)


def test_rotated_files_are_read_first(tmp_path: Path):
    (tmp_path / "events.jsonl.1").write_text(f"{run_events.line(event(0.0, 'started', 'a-1'))}\n")
    (tmp_path / "events.jsonl").write_text(f"{run_events.line(event(1.0, 'ready', 'a-1'))}\n")
    assert read(str(tmp_path)).processes["a-1"].ready_s == pytest.approx(1.0)


def test_a_folder_without_events_is_refused(tmp_path: Path):
    with pytest.raises(UsageError, match="cannot read"):
        read(str(tmp_path))


SOME_EVENTS = [
    run_events.event(kind) for kind in ("waiting", "started", "ready", "ended", "not started")
]
RELEASES = [
    run_events.event("released", why=why, processes=names)
    for why in ("ready", "timeout")
    for names in ((), ("a-1",), ("b-2", "gone"))
]


@given(
    st.lists(
        st.builds(
            run_events.entry,
            st.sampled_from([*SOME_EVENTS, *RELEASES]),
            st.floats(0, 100),
            st.sampled_from(["a-1", "b-2", "\x1b[31mc-3"]),
        )
    )
)
def test_any_order_of_events_makes_a_report(events):
    found = timeline("x", events)
    if found.processes:
        assert "\x1b" not in "\n".join(lines(found, 80))
        json.dumps(document(found))
