"""Faults of processes that listen to each other: talker-1 -> /t -> listener-2 -> /u -> wheels-3."""

from __future__ import annotations

import pytest

from tests.faults.unit.test_implied_checks import MISMATCH
from tests.faults.unit.watched import LISTENER, LOOK_S, PAIR, TALKER, WatchedRun, row
from tests.smoke.unit.facts import publisher, subscription

WHEELS = row("wheels-3", 13, node_names=["/wheels"])
CHAIN = (*PAIR, publisher("/u", "/listener"), subscription("/u", "/wheels"))
RATE, GAP = "rate: /t, is: 9 to 11 Hz", "gap: /u, below: 500 ms"


def flow(run: WatchedRun, seconds: float, *topics: str, delay_s: float = 0.0) -> None:
    """Messages of 10 Hz on these topics."""
    until_s = run.now_s + seconds
    while run.now_s < until_s:
        for topic in topics:
            run.arrive(topic, run.now_s - LOOK_S / 2, run.now_s, delay_s=delay_s)
        run.look()


def chain(*expect: str) -> WatchedRun:
    run = WatchedRun(*(expect or (RATE, GAP)))
    run.rows(TALKER, LISTENER, WHEELS)
    run.graph(*CHAIN)
    flow(run, 6, "/t", "/u")
    assert run.reports == []
    return run


def asked(run: WatchedRun, verb: str) -> None:
    """A user has requested it, and the talker has ended."""
    run.happen("asked", "talker-1", verb=verb)
    run.happen("ended", "talker-1", returncode=-15, asked=True)
    run.rows(row("talker-1", None, node_names=["/talker"]), LISTENER, WHEELS)


def started(run: WatchedRun) -> None:
    run.happen("started", "talker-1", restarts=1)
    run.rows({**TALKER, "pid": 21, "uptime_s": 0.2}, LISTENER, WHEELS)


def roots(run: WatchedRun) -> list[str]:
    return [one.root.id for one in run.incidents]


def test_what_is_silent_since_it_hears_nothing_follows_from_that():
    run = chain()
    run.wait(5)

    assert roots(run) == ["rate /t"]
    assert run.fault("gap /u").follows == "rate /t"
    assert run.changes("gap /u").count("confirmed") == 1


def test_a_silence_of_its_own_is_a_root_although_it_listens_to_others():
    run = chain()
    flow(run, 4, "/t")

    assert roots(run) == ["gap /u"]
    assert run.fault("gap /u").rule == "publisher"


def test_a_restart_by_a_user_is_no_fault_of_what_listens_to_it_either():
    run = chain()
    asked(run, "restart")
    flow(run, 1.5)
    started(run)
    flow(run, 1.5)
    flow(run, 10, "/t", "/u")

    assert run.reports == []


@pytest.mark.parametrize("expect", [(RATE, GAP), (GAP,)])
def test_what_a_user_has_stopped_explains_what_listens_to_it(expect: tuple[str, ...]):
    run = chain(*expect)
    asked(run, "kill")
    run.wait(9)
    gap = run.fault("gap /u").document(float)

    assert len(run.incidents) == 1
    assert "a user has killed talker-1" in run.incidents[0].title
    assert gap["cause"] is None or gap["rule"] == "upstream"


def test_a_death_of_one_that_was_started_again_after_a_request_is_no_request():
    run = chain(RATE, "node: /talker, confirm: 0.2 s")
    asked(run, "kill")
    run.happen("asked", "talker-1", verb="start")
    started(run)
    flow(run, 9, "/t", "/u")
    run.happen("ended", "talker-1", returncode=-9)
    run.rows(row("talker-1", None, node_names=["/talker"]), LISTENER, WHEELS)
    run.graph(*CHAIN[1:])
    run.wait(4)

    assert {fault.rule for fault in run.table.faults.values()} == {"death"}
    assert roots(run) == ["no deaths: talker-1"]


def test_a_fault_that_does_no_harm_hides_no_later_one():
    run = chain(RATE, "no_errors: talker")
    for _ in range(10):
        run.print("[ERROR] lens dirty")
        flow(run, 2, "/t", "/u")
    assert roots(run) == ["no errors talker"]
    run.wait(4)

    assert roots(run) == ["no errors talker", "rate /t"]


def test_what_is_itself_a_cause_is_the_root():
    run = chain("gap: /t, below: 300 ms")
    run.story.stops.is_stopped = lambda pid: pid == 11  # type: ignore[method-assign]
    run.wait(3)

    assert roots(run) == ["not suspended: talker-1"]
    assert run.fault("gap /t").follows == "not suspended: talker-1"


def test_a_mismatch_explains_nothing_of_messages_that_come():
    run = chain("latency: /t, below: 100 ms")
    run.graph(*CHAIN, mismatches=[MISMATCH])
    flow(run, 5, "/t", delay_s=0.5)

    assert run.fault("latency /t").rule == "publisher"


def test_a_side_that_a_reload_has_dropped_is_not_missed():
    run = chain()
    run.rows(TALKER, LISTENER)
    run.graph(*CHAIN[:3])
    flow(run, 5, "/t", "/u")

    assert run.reports == []
