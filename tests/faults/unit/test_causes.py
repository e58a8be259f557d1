"""Causes: the rule that explains a fault, and what it must not explain; incidents."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from launcher.faults.causes.rules import RULES
from launcher.faults.watcher.incident_files import IncidentFiles, first_number
from launcher.ros.snapshot.ros_graph import Endpoint
from tests.faults.unit.test_implied_checks import MISMATCH
from tests.faults.unit.watched import LISTENER, PAIR, TALKER, WatchedRun, row
from tests.smoke.unit.facts import publisher, subscription

RATE = "rate: /t, is: 9 to 11 Hz"


def talking(*ends: Endpoint, expect: tuple[str, ...] = (RATE,)) -> WatchedRun:
    run = WatchedRun(*expect)
    run.rows(TALKER, LISTENER)
    run.graph(*PAIR, *ends)
    run.wait(6, hz=10)
    return run


def restarted(run: WatchedRun) -> None:
    run.happen("ended", "talker-1", returncode=1, restart_in_s=0.5)
    run.wait(0.4)
    run.happen("started", "talker-1", restarts=1)


def died(run: WatchedRun) -> None:
    run.happen("ended", "talker-1", returncode=-9)
    run.rows(row("talker-1", None, node_names=["/talker"]), LISTENER)


def other_died(run: WatchedRun) -> None:
    run.happen("ended", "other-3", returncode=-9)


def died_long_before(run: WatchedRun) -> None:
    restarted(run)
    run.wait(14, hz=10)


def clock_set(run: WatchedRun) -> None:
    run.machine(run.now_s)
    run.machine(run.now_s + 0.1, clock_s=5.0)


def clock_set_long_before(run: WatchedRun) -> None:
    clock_set(run)
    run.wait(12, hz=10)


def link_down(run: WatchedRun) -> None:
    run.rows({**TALKER, "host": "bot1"}, LISTENER)
    run.happen("link", None, host="bot1", state="unreachable", reason="timed out")


def other_link_down(run: WatchedRun) -> None:
    run.rows(TALKER, LISTENER, {**row("far-3", 13), "host": "bot1"})
    run.happen("link", None, host="bot1", state="unreachable", reason="timed out")


def paused(run: WatchedRun) -> None:
    run.happen("asked", "talker-1", verb="pause")
    run.rows({**TALKER, "paused": True}, LISTENER)
    run.wait(5.2)


def paused_and_resumed(run: WatchedRun) -> None:
    run.happen("asked", "talker-1", verb="pause")
    run.wait(5.2, hz=10)
    run.rows({**TALKER, "paused": False}, LISTENER)


def two_of_a_name(run: WatchedRun) -> None:
    run.graph(*PAIR, nodes=[{"name": "/talker", "count": 2}, {"name": "/listener"}])


def two_of_another_name(run: WatchedRun) -> None:
    run.graph(*PAIR, nodes=[{"name": "/talker"}, {"name": "/listener", "count": 2}])


def mismatched(run: WatchedRun) -> None:
    run.graph(*PAIR, mismatches=[MISMATCH])


def mismatched_elsewhere(run: WatchedRun) -> None:
    run.graph(*PAIR, mismatches=[{**MISMATCH, "topic": "/u"}])


def busy(run: WatchedRun) -> None:
    for _ in range(3):
        run.rows({**TALKER, "cpu_percent": 99.0}, LISTENER)


def listener_busy(run: WatchedRun) -> None:
    for _ in range(3):
        run.rows(TALKER, {**LISTENER, "cpu_percent": 99.0})


def starved(run: WatchedRun, *, talker: float = 0.6, pressure: float = 0.9) -> None:
    run.story.delays.share = lambda pid: talker if pid == 11 else 0.0  # type: ignore[method-assign]
    for number in range(-20, 40):
        run.machine(run.now_s + number / 2, pressure={"cpu": pressure})


def others_starved(run: WatchedRun) -> None:
    starved(run, talker=0.0)


def starved_too_little(run: WatchedRun) -> None:
    """It has waited, and not for as long as nothing came."""
    starved(run, talker=0.3)


def hardly_starved(run: WatchedRun) -> None:
    starved(run, pressure=0.2)


@pytest.mark.parametrize(
    ("before", "rule", "text"),
    [
        (clock_set, "clock step", "the clock of this machine was set forward by 5 s"),
        (clock_set_long_before, "publisher", "talker-1 runs, and"),
        (link_down, "lost link", "the link to host bot1 is down (timed out)"),
        (other_link_down, "publisher", "talker-1 runs, and"),
        (paused, "request", "a user has paused talker-1"),
        (paused_and_resumed, "publisher", "talker-1 runs, and"),
        (two_of_a_name, "double node", "there are several nodes /talker"),
        (two_of_another_name, "publisher", "talker-1 runs, and"),
        (mismatched, "QoS", "/listener receives nothing from /talker: reliability is"),
        (mismatched_elsewhere, "publisher", "talker-1 runs, and"),
        (died, "death", "talker-1 died (SIGKILL)"),
        (other_died, "publisher", "talker-1 runs, and"),
        (restarted, "death", "talker-1 died (exit code 1), and was started again"),
        (died_long_before, "publisher", "talker-1 runs, and"),
        (busy, "busy process", "talker-1 is busy: 99 % of a core"),
        (listener_busy, "publisher", "talker-1 runs, and"),
        (starved, "starvation", "programs wait for a processor 90% of the time"),
        (others_starved, "publisher", "talker-1 runs, and"),
        (starved_too_little, "publisher", "talker-1 runs, and"),
        (hardly_starved, "publisher", "talker-1 runs, and"),
    ],
)
def test_why_a_topic_is_silent(before: Callable[[WatchedRun], None], rule: str, text: str):
    run = talking()
    before(run)
    run.wait(4)
    fault = run.fault("rate /t")

    assert fault.is_active
    assert (fault.rule, str(fault.cause)[: len(text)]) == (rule, text)


def test_a_qos_mismatch_since_a_restart_says_so():
    run = talking()
    restarted(run)
    run.wait(5, hz=10)
    mismatched(run)
    run.wait(3)

    assert str(run.fault("rate /t").cause).endswith(" since the restart of talker-1")
    assert run.fault("QoS: /t").incident == run.fault("rate /t").incident


def test_a_topic_that_arrives_is_not_explained_by_a_subscription_that_does_not_match():
    run = talking()
    mismatched(run)
    run.wait(5, hz=5)

    assert run.fault("rate /t").rule == "publisher"
    assert "publishes /t at 5" in str(run.fault("rate /t").cause)


def test_a_restart_on_request_explains_a_gap_but_no_growth():
    run = talking(expect=("gap: /t, below: 2 s", "cpu: talker, below: 50 %"))
    run.happen("asked", "talker-1", verb="restart")
    run.happen("ended", "talker-1", returncode=0, asked=True)
    run.happen("started", "talker-1", restarts=1)
    for _ in range(12):
        run.rows({**TALKER, "cpu_percent": 70.0}, LISTENER)
        run.wait(1)
    gap, cpu = run.fault("gap /t"), run.fault("cpu talker")

    assert gap.rule == "restart" and "talker-1 was restarted " in str(gap.cause)
    assert cpu.rule != "restart"


def test_a_full_disk_explains_errors_that_say_so():
    causes = []
    for text in ("[ERROR] No space left on device", "[ERROR] no such file"):
        run = talking(expect=("no_errors: '*'",))
        run.machine(run.now_s, free_bytes=0, size_bytes=10**12)
        run.print(text)
        run.wait(2)
        causes.append(run.fault("no errors *").rule)
    assert causes[0] == "full disk" and causes[1] != "full disk"


def test_each_rule_says_nothing_of_a_fault_about_nothing():
    run = WatchedRun("node: /x")
    run.graph(subscription("/u"))
    run.wait(1)
    assert [rule(run.only(), run.story) for rule in RULES if rule.__name__ != "guess"] == [None] * (
        len(RULES) - 1
    )


# ---- incidents


def test_what_follows_from_a_death_is_one_incident():
    run = talking(expect=(RATE, "node: /talker"))
    died(run)
    run.graph(subscription("/t"))
    run.wait(6)
    root = run.fault("no deaths: talker-1")

    assert len(run.incidents) == 1 and run.incidents[0].root is root
    assert {f.id for f in run.incidents[0].faults} == {
        root.id,
        "rate /t",
        "node /talker",
        "both sides: /t",
    }
    assert {f.follows for f in run.incidents[0].faults} == {None, root.id}
    assert run.incidents[0].title == "talker-1 died (SIGKILL)"


def test_a_death_does_not_follow_from_what_was_wrong_before():
    run = talking(publisher("/q"), subscription("/q"))
    run.graph(*PAIR, mismatches=[{**MISMATCH, "topic": "/q"}])
    run.wait(2, hz=10)
    died(run)
    run.wait(4)

    assert [one.root.id for one in run.incidents] == ["QoS: /q", "no deaths: talker-1"]
    assert run.fault("rate /t").follows == "no deaths: talker-1"


def test_what_has_nothing_to_do_with_it_is_another_incident():
    run = talking(expect=(RATE, "no_errors: far"))
    run.rows(TALKER, LISTENER, row("far-3", 13))
    died(run)
    run.print("[ERROR] bad", process="far-3")
    run.wait(4)

    assert [one.root.id for one in run.incidents] == ["no deaths: talker-1", "no errors far"]


def test_an_incident_is_over_when_all_of_it_is_healed_and_a_later_one_is_new():
    run = talking()
    run.wait(3)
    run.wait(6, hz=10)
    assert [one.closed_s is not None for one in run.incidents] == [True]
    run.wait(3)
    assert len(run.incidents) == 2
    assert run.fault("rate /t").incident == 2


def test_a_weak_cause_is_revised_when_the_event_comes_later():
    run = talking()
    run.wait(2)
    assert run.fault("rate /t").rule == "publisher"
    run.look(events=(run.event("ended", "talker-1", at_s=run.now_s - 1.5, returncode=-9),))
    run.wait(1)

    assert run.fault("rate /t").rule == "death"
    assert "updated" in run.changes("rate /t")


def test_numbers_of_causes_and_incidents_are_bounded():
    run = talking()
    for _ in range(210):
        run.wait(1.8)
        run.wait(4.2, hz=10)
    incidents = run.table.incidents

    assert run.fault("rate /t").life.count == 210
    assert len(incidents) <= 201
    assert max(len(one.causes) for one in incidents) <= 3


# ---- files


def files(tmp_path: Any, notes: list[str]) -> IncidentFiles:
    return IncidentFiles(str(tmp_path), {"run": {"id": "1"}}, lambda s: s, notes.append)


def test_an_incident_is_written_when_it_opens_goes_on_and_is_over(tmp_path: Any):
    notes: list[str] = []
    run, written = talking(), files(tmp_path, notes)
    died(run)
    run.wait(2)
    (incident,) = run.incidents
    written.opened(incident, run.story)
    path = tmp_path / "incidents" / "1.json"
    first = path.read_text()
    assert '"closed_s":null' in first.replace(" ", "") and "talker-1 died" in first
    assert first_number(str(tmp_path)) == 2

    run.wait(6)
    written.refresh([incident], run.story)
    assert path.read_text() != first
    incident.closed_s = run.now_s
    written.closed(incident, run.story)
    assert '"closed_s":null' not in path.read_text().replace(" ", "")
    written.refresh([], run.story)  # it was joined with another, or is old
    assert not path.exists() and not written._before and not written._written
    assert notes == []


def test_a_folder_that_cannot_be_written_is_reported_once(tmp_path: Any):
    notes: list[str] = []
    (tmp_path / "incidents").write_text("a file")
    run, written = talking(), files(tmp_path, notes)
    died(run)
    run.wait(2)
    for _ in range(3):
        written.opened(run.incidents[0], run.story)

    assert len(notes) == 1 and notes[0].startswith("cannot write ")
    without = IncidentFiles(None, {}, lambda s: s, notes.append)
    without.opened(run.incidents[0], run.story)
    assert len(notes) == 1
