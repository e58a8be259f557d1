"""A watched run on several hosts: whose pids are looked at, lost links, and other clocks."""

from __future__ import annotations

from typing import Any

import pytest

from launcher.base.model.run_events import Ended, LinkChanged
from launcher.faults.causes.rules import cause_of
from launcher.faults.checks.check import Check, Found
from launcher.faults.checks.implied import HostCheck, SuspensionCheck
from launcher.faults.checks.traffic import RateCheck
from launcher.faults.model.fault import Fault, FaultFinding, FaultOrigin
from launcher.faults.watcher.fault_table import FaultTable
from launcher.faults.watcher.story import KEEP_S, Story, TopicArrivals
from launcher.smoke.observe.facts import Facts, ProcessEvent


def row(name: str, pid: int, host: str | None = None, silent_s: float | None = 0.3) -> Any:
    found = {"name": name, "pid": pid, "node_names": [f"/{name}"], "state": "RUNNING"}
    found |= {"cpu_percent": 1.0, "rss_bytes": 1, "uss_bytes": 1, "uptime_s": 60.0, "paused": False}
    return found if host is None else {**found, "host": host, "host_silent_s": silent_s}


def link(at_s: float, state: str) -> ProcessEvent[LinkChanged]:
    return ProcessEvent(at_s=at_s, event=LinkChanged("bot", state, ""))


class FaultsOfHosts:
    """The faults of a story that goes on."""

    def __init__(self) -> None:
        self.story = Story()
        self.reports: list[tuple[str, str, str | None]] = []
        self.table = FaultTable(self._report)
        self._hosts = HostCheck()
        self._rate = Check()
        self._rate.debounce = RateCheck.debounce

    def _report(self, fault: Fault, change: str) -> None:
        self.reports.append((fault.id, change, fault.follows))

    def look(self, now_s: float, *events: Any, silent: str | None = None) -> None:
        """With what is new, and `silent`: the process whose topic has no messages."""
        self.story.take(Facts(now_s=now_s, events=events))
        for found in self._hosts.look(self.story):
            self.table.take(self._hosts, found, self.story)
        if silent is not None:
            origin = FaultOrigin(fault="rate", expectation="rate", kind="rate", expected="10 Hz")
            finding = FaultFinding(seen="silent", processes=(silent,), value=0.0, since_s=now_s - 2)
            self.table.take(self._rate, Found(origin, finding), self.story)
        self.table.decide(self.story)


@pytest.mark.parametrize(("host", "is_seen"), [(None, True), ("local", True), ("bot", False)])
def test_only_processes_of_this_machine_are_looked_at_by_their_pids(
    host: str | None, is_seen: bool, monkeypatch: pytest.MonkeyPatch
):
    story = Story()
    story.take_rows([row("a-1", 77, host)], 0.0)
    story.take(Facts(now_s=1.0))
    monkeypatch.setattr(story.stops, "is_stopped", lambda pid: pid == 77)
    assert bool([*SuspensionCheck().look(story)]) is is_seen
    story.take_graph({"nodes": [{"name": "/other", "pid": 77}]}, 0.0)
    assert story.process_of("/other") == ("a-1" if is_seen else None)


def test_a_host_is_lost_until_it_returns():
    story = Story()
    story.take(Facts(now_s=1.0, events=(link(1.0, "unreachable"),)))
    story.take(Facts(now_s=2 * KEEP_S))
    assert [*story.lost_hosts()] == ["bot"]
    story.take(Facts(now_s=2 * KEEP_S + 1, events=(link(2 * KEEP_S + 1, "ready"),)))
    assert not story.lost_hosts()


def test_what_is_silent_with_its_host_follows_from_the_lost_link_that_is_noticed_later():
    run = FaultsOfHosts()
    run.story.take_rows([row("a-1", 77, "bot", 2.1)], 100.0)
    run.look(100.0, silent="a-1")
    assert run.table.faults["rate"].cause == "nothing has come from host bot for 2 s"
    assert run.reports[-1] == ("rate", "confirmed", None)
    run.look(101.0, link(101.0, "unreachable"), silent="a-1")
    assert ("reachable: bot", "confirmed", None) in run.reports
    assert run.reports[-1] == ("rate", "updated", "reachable: bot")
    assert len({fault.incident for fault in run.table.faults.values()}) == 1


def test_a_fault_elsewhere_is_explained_when_its_host_had_time_to_be_heard():
    run = FaultsOfHosts()
    run.story.take_rows([row("a-1", 77, "bot", 0.9)], 100.0)
    for tenth in range(15):
        run.look(100.0 + tenth / 10, silent="a-1")
    assert not [one for one in run.reports if one[1] == "confirmed"]
    run.story.take_rows([row("a-1", 77, "bot", 0.4)], 101.6)
    run.look(101.8, silent="a-1")
    assert run.table.faults["rate"].rule == "publisher"


def test_a_death_that_is_reported_is_not_explained_by_the_link():
    run = FaultsOfHosts()
    run.story.take_rows([row("a-1", 77, "bot", 9.0)], 100.0)
    run.look(100.0, link(100.0, "unreachable"))
    origin = FaultOrigin(fault="x", expectation="x", kind="no deaths", expected="")
    fault = Fault.of(origin, HostCheck.debounce, FaultFinding(seen="died", processes=("a-1",)))
    fault.life.violated(100.0)
    cause = cause_of(fault, run.story)
    assert cause is None or cause.rule != "lost link"


def test_a_process_that_its_host_has_stopped_without_the_link_is_missing_for_that():
    story = Story()
    story.take_rows([{**row("a-1", 77, "bot"), "pid": None, "state": "STOPPED"}], 30.0)
    ended = Ended(pid=77, returncode=0, asked=True, restart_in_s=None)
    events = (
        link(10.0, "unreachable"),
        ProcessEvent(at_s=18.0, event=ended, process="a-1", host="bot"),
        link(25.0, "ready"),
    )
    story.take(Facts(now_s=31.0, events=events))
    origin = FaultOrigin(fault="x", expectation="x", kind="node", expected="")
    finding = FaultFinding(seen="it is not there", processes=("a-1",), guess="it has ended")
    fault = Fault.of(origin, RateCheck.debounce, finding)
    fault.life.violated(31.0)
    cause = cause_of(fault, story)
    assert cause is not None
    assert cause.text == "host bot has stopped a-1 while the link was down"


def test_a_busy_machine_explains_what_is_late_elsewhere_unless_the_host_turns_out_to_be_silent(
    monkeypatch: pytest.MonkeyPatch,
):
    run = FaultsOfHosts()
    run.story.observer = 5
    monkeypatch.setattr(run.story, "pressure", lambda resource, since_s: 0.9)
    monkeypatch.setattr(run.story.delays, "share", lambda pid: {5: 0.5}.get(pid))
    run.story.take_rows([row("a-1", 77, "bot", 0.9)], 100.0)
    run.look(100.0, silent="a-1")
    run.story.take_rows([row("a-1", 77, "bot", 1.9)], 101.0)
    run.look(101.1, silent="a-1")
    assert run.table.faults["rate"].rule == "lost link"
    other = FaultsOfHosts()
    other.story = run.story
    other.story.take_rows([row("a-1", 77, "bot", 0.2)], 102.0)
    for tenth in range(20):
        other.look(103.0 + tenth / 10, silent="a-1")
    assert other.table.faults["rate"].rule == "starvation"


@pytest.mark.parametrize("ahead_s", [-30.0, -2.0, 0.0, 2.0, 30.0])
def test_times_of_a_publisher_with_another_clock_are_those_of_this_machine(ahead_s: float):
    arrivals = TopicArrivals()
    for number in range(30):
        sent_s = 100.0 + number / 10
        arrivals.add([sent_s + 0.01 + number % 3 / 100], [sent_s + ahead_s])
    shifts = [sent_s - (100.0 + n / 10) for n, sent_s in enumerate(arrivals.sent)]
    assert all(abs(shift_s) < 0.05 for shift_s in shifts)
    assert len(arrivals.sent_since(102.0 - 0.05)) in (10, 11)


@pytest.mark.parametrize(
    ("host", "behind_s", "rule"),
    [("bot", 2.0, "other clock"), ("bot", 0.1, "publisher"), ("local", 2.0, "publisher")],
)
def test_a_clock_that_is_behind_explains_late_messages_of_its_host(
    host: str, behind_s: float, rule: str
):
    story = Story()
    story.take_rows([row("a-1", 77, host)], 9.0)
    story.take(Facts(now_s=10.0))
    story.arrivals["/a"] = arrivals = TopicArrivals()
    arrivals.add([9.0, 9.1], [9.0 - behind_s, 9.1 - behind_s])
    origin = FaultOrigin(fault="x", expectation="x", kind="latency", expected="")
    finding = FaultFinding(seen="late", processes=("a-1",), topics=("/a",))
    fault = Fault.of(origin, RateCheck.debounce, finding)
    fault.life.violated(10.0)
    cause = cause_of(fault, story)
    assert cause is not None and cause.rule == rule


def test_messages_that_come_late_together_count_when_they_were_sent():
    arrivals = TopicArrivals()
    for number in range(20):
        arrivals.add([100.01 + number / 10], [100.0 + number / 10])
    arrivals.add([103.5] * 5, [102.0 + number / 10 for number in range(5)])
    assert [*arrivals.sent][-5:] == [102.0, 102.1, 102.2, 102.3, 102.4]
