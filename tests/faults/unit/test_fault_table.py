"""The faults of a run: what is reported, muted, acknowledged and forgotten."""

from __future__ import annotations

import time
from typing import Any

import pytest

from launcher.faults.watcher import fault_table
from launcher.faults.watcher.observations import Observations
from launcher.smoke.expect.expectation import START
from launcher.smoke.observe.facts import Facts, LogLine, QueryAnswer, UsageSample
from tests.faults.unit.watched import LISTENER, PAIR, TALKER, WatchedRun
from tests.smoke.unit.facts import subscription

NODE = "node /talker"


def absent(*, confirm: str = "0.6 s") -> WatchedRun:
    """A run whose node has just left."""
    run = WatchedRun(f"node: /talker, confirm: {confirm}, heal: 0.2 s")
    run.rows(TALKER, LISTENER)
    run.graph(*PAIR)
    run.graph(subscription("/t"))
    return run


def test_a_fault_that_heals_before_its_cause_is_known_is_confirmed_first():
    run = absent(confirm="0.2 s")
    run.look()
    run.graph(*PAIR)
    run.look()

    assert run.changes(NODE) == ["suspected", "confirmed", "healed"]
    assert run.fault(NODE).incident == 1
    assert run.incidents[0].closed_s is not None


def test_of_a_fault_that_is_suspected_again_the_old_cause_says_nothing():
    run = absent()
    run.wait(2)
    run.graph(*PAIR)
    run.wait(1)
    run.graph(subscription("/t"))
    again = run.reports[-1][1]

    assert run.changes(NODE)[-1] == "suspected"
    assert [again[name] for name in ("cause", "rule", "follows", "incident")] == [None] * 4


def test_what_follows_from_another_has_no_weak_cause_that_contradicts_it():
    run = WatchedRun("node: /talker, confirm: 0.2 s", "rate: /t, is: 9 to 11 Hz")
    run.rows(TALKER, LISTENER)
    run.graph(*PAIR)
    run.wait(20, hz=10)
    run.graph(subscription("/t"))
    run.wait(6)
    node, rate = (run.fault(name).document(float) for name in (NODE, "rate /t"))

    assert rate["follows"] == NODE
    assert run.fault("rate /t").rule == "publisher"
    assert (rate["cause"], rate["rule"]) == (None, None)
    assert node["incident"] == rate["incident"]


def test_a_suspicion_that_was_none_is_forgotten():
    run = absent()
    run.graph(*PAIR)

    assert run.changes(NODE) == ["suspected", "dismissed"]
    assert run.states() == {}


def test_a_suspicion_of_a_fault_that_was_one_before_leaves_it_as_it_was():
    run = absent()
    run.wait(2)
    run.graph(*PAIR)
    run.wait(1)
    before = run.reports[-1][1]
    run.graph(subscription("/t"))
    run.graph(*PAIR)
    run.look()
    change, after = run.reports[-1]

    assert (change, before["state"], before["count"]) == ("dismissed", "healed", 1)
    assert {**after, "seen": before["seen"]} == before


def test_what_is_acknowledged_is_so_until_it_comes_again():
    run = absent()
    run.wait(2)
    run.table.acknowledge(NODE, "I see")
    run.graph(*PAIR)
    run.wait(1)
    assert run.fault(NODE).acknowledged is not None
    run.graph(subscription("/t"))
    run.wait(2)
    assert run.fault(NODE).is_active and run.fault(NODE).acknowledged is None
    with pytest.raises(KeyError):
        run.table.acknowledge("no such", None)


def test_a_mute_ends_in_time_and_holds_for_what_comes_again():
    run = absent()
    run.wait(2)
    run.table.mute(NODE, "tests", time.time() + 100)
    run.table.end_mutes()
    assert run.fault(NODE).muted == {
        "reason": "tests",
        "until_s": pytest.approx(time.time() + 100, abs=50),
    }
    run.table.mute(NODE, "tests", time.time() - 1)
    run.table.end_mutes()
    assert run.fault(NODE).muted is None and run.table.mutes == {}
    assert run.changes(NODE)[-1] == "updated"
    run.table.mute(NODE, None, None)
    run.table.end_mutes()
    assert run.table.unmute(NODE).muted is None


def test_a_mute_of_an_earlier_run_holds_from_the_beginning():
    run = WatchedRun()
    run.table.mutes["no deaths: talker-1"] = {"reason": "known", "until_s": None}
    run.rows(TALKER)
    run.happen("ended", "talker-1", returncode=1)
    run.wait(1)
    assert run.reports[-1][1]["muted"] == {"reason": "known", "until_s": None}


def test_ids_that_healed_long_ago_are_forgotten_everywhere(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(fault_table, "MOST_FAULTS", 20)
    run = WatchedRun()
    for number in range(60):
        run.happen("ended", f"job-{number}", returncode=1)
        run.wait(0.4)
        run.happen("ended", f"job-{number}", returncode=0)
        run.wait(0.4)
    confirmed = [one["fault"] for change, one in run.reports if change == "confirmed"]
    forgotten = [one["fault"] for change, one in run.reports if change == "forgotten"]

    assert confirmed == [f"no deaths: job-{number}" for number in range(60)]
    assert len(run.table.faults) <= 22
    assert len(run.table._reported) <= 22
    assert confirmed[: len(forgotten)] == forgotten


def test_what_changes_all_the_time_is_reported_once_a_second():
    run = WatchedRun("rate: /t, is: 9 to 11 Hz")
    run.rows(TALKER, LISTENER)
    run.graph(*PAIR)
    run.wait(5, hz=10)
    run.wait(12)
    assert 8 <= run.changes("rate /t").count("updated") <= 12


def test_what_is_muted_before_it_is_seen_is_muted_then():
    run = WatchedRun("rate: /t, is: 9 to 11 Hz")
    assert run.table.mute("rate /t", "why not", None) is None
    assert run.table.mute("other", None, None) is None and run.table.unmute("other") is None
    with pytest.raises(KeyError):
        run.table.unmute("other")
    run.rows(TALKER, LISTENER)
    run.graph(*PAIR)
    run.wait(5, hz=10)
    run.wait(5)
    assert run.fault("rate /t").muted == {"reason": "why not", "until_s": None}


# ---- observations


def test_taken_observations_are_gone_but_for_the_last_answers():
    seen = Observations()
    line = LogLine(at_s=1.0, process="a", text="x")
    seen.add(line)
    seen.add_samples([UsageSample(1.0, "a")], {"a": ("/a",)})
    seen.add_trouble("late")
    for value in (1, 2):
        seen.add_answer("k", QueryAnswer(at_s=1.0, value=value))
    first, second = seen.take(), seen.take()

    assert (first.lines, len(first.samples), first.troubles) == ((line,), 1, ("late",))
    assert [one.value for one in first.answers["k"]] == [1, 2]
    assert [one.value for one in second.answers["k"]] == [2]
    assert (second.lines, second.samples, second.troubles, second.messages) == ((), (), (), ())
    assert second.node_names == {"a": ("/a",)} and second.steps == {START: 0.0}
    assert isinstance(second, Facts) and second.now_s >= first.now_s


def test_times_of_the_day_are_never_in_the_future(monkeypatch: pytest.MonkeyPatch):
    seen, at_s = Observations(), time.time()
    back_s: Any = at_s - 7200
    monkeypatch.setattr(time, "time", lambda: back_s)

    assert seen.of_wall(at_s) <= seen.now_s
    assert seen.wall_of(seen.now_s) == pytest.approx(back_s)
