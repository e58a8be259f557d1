"""What every watched run expects."""

from __future__ import annotations

import os
import signal
import subprocess
from dataclasses import replace

import pytest

from launcher.faults.checks.live_checks import KINDS
from launcher.faults.watcher.fault_table import REFRESH_S
from launcher.smoke.expect.expectation_kinds import KINDS as ALL_KINDS
from tests.faults.unit.watched import LISTENER, PAIR, TALKER, WatchedRun, row
from tests.smoke.unit.facts import publisher, subscription

DEATH = "no deaths: talker-1"


def test_each_kind_of_expectations_is_checked_or_left_with_a_reason():
    assert {kind.name for kind in ALL_KINDS} == KINDS.keys() | {"no_deaths"}


# ---- deaths


def test_a_death_that_is_not_restarted_stays():
    run = WatchedRun()
    run.rows(TALKER)
    run.happen("ended", "talker-1", returncode=-9)
    run.rows(row("talker-1", None))
    run.wait(400)

    assert run.states() == {DEATH: "active"}
    changes = run.changes(DEATH)
    assert changes[0] == "confirmed"
    assert set(changes[1:]) == {"updated"}  # that it is still so
    assert len(changes) <= 1 + 400 / REFRESH_S
    assert run.only().finding.seen == "talker-1 died (SIGKILL)"
    assert run.only().cause == run.only().finding.seen


@pytest.mark.parametrize("kind", ["restarted", "stopped by a user", "dropped by a reload"])
def test_a_death_is_over(kind: str):
    run = WatchedRun()
    run.rows(TALKER)
    run.happen("ended", "talker-1", returncode=1)
    run.wait(1)
    if kind == "restarted":
        run.happen("started", "talker-1", restarts=1)
        run.wait(1)
        run.rows({**TALKER, "pid": 21, "uptime_s": 1.0})
        run.look()
        assert run.states() == {DEATH: "active"}
        run.wait(2)
        run.rows({**TALKER, "pid": 21, "uptime_s": 3.2})
    elif kind == "stopped by a user":
        run.happen("ended", "talker-1", returncode=-15, asked=True)
    else:
        run.wait(2)
        run.rows(LISTENER)
    run.look()

    assert run.states() == {DEATH: "healed"}
    assert run.changes(DEATH) == ["confirmed", "healed"]


def test_an_end_that_is_requested_or_expected_is_no_death():
    run = WatchedRun("process: 'job_*', exits: 3")
    run.rows(TALKER, row("job_1-2", 12))
    run.happen("ended", "talker-1", returncode=-15, asked=True)
    run.happen("ended", "job_1-2", returncode=3)
    run.wait(3)

    assert run.states() == {}
    assert [one.why for one in run.left] == ["an exit is the end of the process"]


def test_what_a_new_watcher_reads_of_an_old_death():
    """All events of the run come at once; what is of minutes ago is not remembered."""
    run = WatchedRun()
    run.rows(TALKER, row("gone-3", None))
    run.look(
        events=(
            run.event("ended", "talker-1", at_s=-900.0, returncode=1),
            run.event("started", "talker-1", at_s=-899.0, restarts=1),
            run.event("ended", "gone-3", at_s=-900.0, returncode=1),
            run.event("not responding", "talker-1", at_s=-890.0),
            run.event("responds", "talker-1", at_s=-880.0),
        )
    )
    run.wait(3)

    assert run.states() == {"no deaths: gone-3": "active"}
    assert run.changes(DEATH) == run.changes("responds: talker-1") == []


def test_faults_that_an_earlier_watcher_has_reported_go_on():
    before = WatchedRun()
    before.rows(TALKER, LISTENER)
    before.happen("ended", "talker-1", returncode=1)
    before.happen("ended", "listener-2", returncode=1)
    before.table.acknowledge("no deaths: listener-2", "I see")
    before.wait(2)
    documents = [fault.document(lambda s: s) for fault in before.table.faults.values()]

    run = WatchedRun()
    run.now_s = before.now_s
    run.table.resume(documents, lambda s: s)
    run.rows({**TALKER, "uptime_s": 0.5}, row("listener-2", None))
    run.look(events=tuple(before.story.events))
    run.wait(2)
    assert set(run.states().values()) == {"active"}
    run.now_s += 3
    run.rows({**TALKER, "uptime_s": 4.0}, row("listener-2", None))
    run.look()
    assert run.states() == {DEATH: "healed", "no deaths: listener-2": "active"}
    assert [change for change, _ in run.reports] == ["healed"]
    assert run.fault("no deaths: listener-2").acknowledged is not None
    run.happen("ended", "talker-1", returncode=1)
    run.wait(1)
    assert run.fault(DEATH).life.count == 2


# ---- processes


def test_a_process_that_is_suspended_by_a_signal():
    with subprocess.Popen(["sleep", "60"]) as sleeper:
        run = WatchedRun()
        run.rows(row("sleep-1", sleeper.pid))
        os.kill(sleeper.pid, signal.SIGSTOP)
        os.waitid(os.P_PID, sleeper.pid, os.WSTOPPED | os.WNOWAIT)
        for _ in range(5):
            run.story.stops.look([sleeper.pid])
        run.wait(0.6)
        assert run.only().finding.seen == "sleep-1 is suspended (SIGSTOP)"
        assert (run.only().rule, run.states()) == (
            "suspension",
            {"not suspended: sleep-1": "active"},
        )
        sleeper.kill()
    run.story.stops.look([])
    run.wait(1.4)
    assert set(run.states().values()) == {"healed"}


def test_a_pause_that_a_user_has_requested_is_no_fault():
    with subprocess.Popen(["sleep", "60"]) as sleeper:
        run = WatchedRun()
        run.rows(row("sleep-1", sleeper.pid))
        run.happen("asked", "sleep-1", verb="pause")
        os.kill(sleeper.pid, signal.SIGSTOP)
        os.waitid(os.P_PID, sleeper.pid, os.WSTOPPED | os.WNOWAIT)
        for _ in range(5):
            run.story.stops.look([sleeper.pid])
        run.wait(10)
        assert run.states() == {}
        sleeper.kill()


def test_nodes_that_do_not_answer():
    run = WatchedRun()
    run.rows(TALKER)
    run.happen("not responding", "talker-1", silent_s=7.0)
    run.wait(5)
    assert run.only().finding.seen == "talker-1 has not answered for 7 s"
    run.happen("responds", "talker-1")
    assert run.states() == {"responds: talker-1": "healed"}


# ---- the graph


def test_two_nodes_of_one_name_are_a_fault_unless_they_are_of_one_process():
    nodes = [{"name": "/talker", "count": 2}, {"name": "/listener", "count": 1}]
    one = replace(publisher("/t"), gid="1" * 35 + ".01")
    other = replace(one, gid="1" * 35 + ".02")
    run = WatchedRun()
    run.rows(TALKER, LISTENER)
    run.graph(one, other, nodes=nodes)
    run.wait(2)
    assert run.states() == {}

    run.graph(one, replace(one, gid="2" * 35 + ".01"), nodes=nodes)
    run.wait(2)
    assert run.states() == {"one node of a name: /talker": "active"}
    assert run.only().rule == "double node"
    assert run.only().finding.topics == ("/t",)
    run.graph(*PAIR)
    run.wait(2)
    assert set(run.states().values()) == {"healed"}


MISMATCH = {
    "topic": "/t",
    "publishers": ["/talker"],
    "subscription": "/listener",
    "policies": [{"policy": "RELIABILITY", "offered": "BEST_EFFORT", "requested": "RELIABLE"}],
}


def test_a_pair_that_does_not_match_unless_that_is_expected():
    runs = WatchedRun(), WatchedRun("qos: /t, compatible: false")
    for run in runs:
        run.rows(TALKER, LISTENER)
        run.graph(*PAIR, mismatches=[MISMATCH])
        run.wait(2)

    assert runs[0].states() == {"QoS: /t": "active"}
    assert "reliability is BEST_EFFORT, but RELIABLE" in str(runs[0].only().cause)
    assert not [name for name in runs[1].states() if name.startswith("QoS")]


def test_a_topic_that_loses_a_side():
    run = WatchedRun()
    run.rows(TALKER, LISTENER)
    run.graph(*PAIR)
    run.wait(1)
    run.graph(subscription("/t"))
    run.wait(4)
    assert run.states() == {}  # it had both sides for a moment only

    run.graph(*PAIR)
    run.wait(4)
    run.graph(subscription("/t"))
    run.wait(3)
    assert run.states() == {"both sides: /t": "active"}
    assert run.only().finding.processes == ("talker-1",)  # who has published it

    again = WatchedRun()  # of another watcher
    again.now_s = run.now_s
    again.table.resume([run.only().document(float)], float)
    again.rows(TALKER, LISTENER)
    again.graph(subscription("/t"))
    again.wait(4)
    assert again.states() == {"both sides: /t": "active"}
    for one in (run, again):
        one.graph(*PAIR)
        one.wait(3)
        assert set(one.states().values()) == {"healed"}


def test_a_process_that_a_user_paused_long_ago_is_not_missed():
    run = WatchedRun()
    run.rows(TALKER)
    run.story.stops.is_stopped = lambda pid: pid == 11  # type: ignore[method-assign]
    run.happen("asked", "talker-1", verb="pause")
    run.now_s += 1000
    run.wait(2)
    assert run.states() == {}
    run.happen("asked", "talker-1", verb="resume")
    run.wait(6)
    assert run.states() == {"not suspended: talker-1": "active"}


def test_topics_and_nodes_that_come_and_go_for_days_are_not_remembered():
    run = WatchedRun()
    run.rows(TALKER, LISTENER)
    for number in range(120):
        topic = f"/t{number}"
        run.graph(publisher(topic), subscription(topic))
        run.wait(3.2)
        run.graph(subscription(topic), mismatches=[{**MISMATCH, "topic": topic}])
        run.wait(3)
        run.graph(nodes=[{"name": "/x"}])
        run.wait(2.4)
    checks = [value for check in run.checks for value in vars(check).values()]

    assert max(len(one) for one in checks if isinstance(one, dict | set)) <= 2
    assert len(run.table.faults) == 240
    assert {*run.states().values()} == {"healed"}
    assert len(run.table._grouping.incidents) <= 201
    assert run.table._undecided == run.table._weak == {}


def test_a_new_probe_has_time_to_discover_what_is_there():
    run = WatchedRun("node: /talker", "rate: /t, is: 9 to 11 Hz")
    run.rows(TALKER, LISTENER)
    run.graph(*PAIR)
    run.wait(5, hz=10)
    run.story.begin_blind()
    run.graph(nodes=[{"name": "/x"}])
    run.story.arrivals.clear()
    run.arrive("/t")
    run.wait(3)
    assert run.reports == []
    run.graph(*PAIR)
    run.wait(5, hz=10)
    assert run.reports == []
    run.graph(subscription("/t"))
    run.wait(2)
    assert run.states()["node /talker"] == "active"


# ---- the machine and other hosts


def test_a_disk_without_room_and_a_clock_that_is_set():
    run = WatchedRun()
    size = 100 * 1024**3
    run.machine(run.now_s, free_bytes=size // 2, size_bytes=size)
    run.look()
    run.machine(run.now_s, free_bytes=10 * 1024**2, size_bytes=size, clock_s=-7200.0)
    run.wait(1)

    assert run.states() == {"disk": "active", "clock": "active"}
    assert run.fault("disk").cause == "the disk of the log files is full"
    assert run.fault("clock").finding.seen == "the clock was set back by 7.2e+03 s"
    run.machine(run.now_s, free_bytes=size // 2, size_bytes=size, clock_s=-7200.0)
    run.wait(7)
    assert set(run.states().values()) == {"healed"}


def test_a_small_disk_needs_little_room_and_a_clock_that_is_slewed_is_none():
    run = WatchedRun()
    for number in range(20):
        run.machine(run.now_s, free_bytes=2**21, size_bytes=2**27, clock_s=number * 0.09)
        run.wait(0.4)

    assert run.states() == {}


def test_a_host_that_cannot_be_reached():
    run = WatchedRun()
    run.rows({**TALKER, "host": "bot1"})
    run.happen("link", None, host="bot1", state="unreachable", reason="timed out")
    run.wait(1)
    assert run.states() == {"reachable: bot1": "active"}
    assert run.only().cause == "the link to host bot1 is down (timed out)"
    run.happen("link", None, host="bot1", state="ready", reason="")
    run.wait(1)
    assert set(run.states().values()) == {"healed"}
