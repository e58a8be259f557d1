"""A watched run by hand: what comes is given, and time passes as the test says."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

from launcher.faults.causes.grouping import Incident
from launcher.faults.checks.live_checks import checks_of, implied_checks, watched
from launcher.faults.model.fault import Fault
from launcher.faults.watcher.fault_table import FaultTable
from launcher.faults.watcher.machine_facts import MachineSample
from launcher.faults.watcher.story import Story, TopicArrivals
from launcher.ros.snapshot.ros_graph import Endpoint
from launcher.smoke.observe.facts import Facts, GraphSeen, LogLine, ProcessEvent
from launcher.smoke.observe.probe_client import snapshot_of
from launcher.smoke.preflight.loader import parse
from tests.smoke.unit.facts import event, publisher, subscription

LOOK_S = 0.2
BEGUN_S = 100.0  # the time of grace is over
MIB = 1024 * 1024


def row(name: str, pid: int | None = 11, **more: Any) -> dict[str, Any]:
    """As `ps` answers."""
    return {
        "name": name,
        "pid": pid,
        "state": "RUNNING" if pid else "STOPPED",
        "node_names": [],
        "cpu_percent": 1.0,
        "rss_bytes": 50 * MIB,
        "uss_bytes": 40 * MIB,
        "uptime_s": 90.0 if pid else None,
        "paused": False,
        **more,
    }


TALKER = row("talker-1", 11, node_names=["/talker"])
LISTENER = row("listener-2", 12, node_names=["/listener"])
PAIR = (publisher("/t"), subscription("/t"))


def document(*ends: Endpoint, nodes: Sequence[dict[str, Any]] = (), **more: Any) -> dict[str, Any]:
    """A graph as the probe reports it."""
    names = dict.fromkeys(end.node for end in ends)
    return {
        "nodes": [*nodes] or [{"name": name, "count": 1} for name in names],
        "endpoints": [asdict(end) for end in ends],
        "topics": [],
        "services": [],
        "mismatches": [],
        **more,
    }


class WatchedRun:
    """`reports` are (change, document) of each report, `now_s` the time of the run."""

    def __init__(self, *entries: str, arguments: Iterable[str] = (), text: str = "") -> None:
        expect = f"expect: [{', '.join(f'{{{one}}}' for one in entries)}]\n"
        script = parse(f"{text}\n{expect if entries else ''}", "x.yaml").completed()
        chosen, self.left = watched(script)
        self.checks = [*implied_checks(script), *checks_of(chosen, [*arguments])]
        self.story = Story()
        self.reports: list[tuple[str, dict[str, Any]]] = []
        self.table = FaultTable(self._report)
        self.incidents: list[Incident] = []
        self.now_s = BEGUN_S

    def _report(self, fault: Fault, change: str) -> None:
        self.reports.append((change, fault.document(lambda at_s: at_s)))

    # ---- what is there

    def rows(self, *rows: dict[str, Any]) -> None:
        self.story.take_rows(rows, self.now_s)

    def graph(self, *ends: Endpoint, **more: Any) -> None:
        reported = document(*ends, **more)
        topics = {end.topic: (end.type,) for end in ends}
        seen = GraphSeen(at_s=self.now_s, snapshot=snapshot_of(reported), topics=topics)
        self.story.take_graph(reported, self.now_s)
        self.look(graphs=(seen,))

    def machine(self, at_s: float, **more: Any) -> None:
        given = {"pressure": {}, "clock_s": 0.0, **more}
        self.story.machine.append(MachineSample(at_s=at_s, **given))

    def arrive(self, topic: str, *times_s: float, delay_s: float = 0.0) -> None:
        """Counted messages that were sent at these times."""
        known = self.story.arrivals.setdefault(topic, TopicArrivals())
        known.received.extend(one + delay_s for one in times_s)
        known.sent.extend(times_s)
        known.delays.extend((one + delay_s, delay_s) for one in times_s)
        self.story.arrivals_s = self.now_s

    # ---- time

    def look(self, **new: Any) -> None:
        """One look, with what is new."""
        self.story.take(Facts(now_s=self.now_s, **new))
        self.story.arrivals_s = self.now_s
        self.table.look(self.checks, self.story)
        self.incidents += [one for one, is_new in self.table.decide(self.story) if is_new]
        [*self.table.closed(self.now_s)]
        self.now_s = round(self.now_s + LOOK_S, 3)

    def happen(self, kind: str, name: str | None = None, **details: Any) -> None:
        """An event, now."""
        self.look(events=(self.event(kind, name, **details),))

    def event(
        self, kind: str, name: str | None = None, at_s: float | None = None, **details: Any
    ) -> ProcessEvent[Any]:
        given = {"asked": False, "restart_in_s": None} if kind == "ended" else {}
        at_s = self.now_s if at_s is None else at_s
        return event(kind, name, at_s, **{**given, **details})  # type: ignore[arg-type]

    def print(self, *texts: str, process: str = "talker-1") -> None:
        """Lines, now."""
        lines = [LogLine(at_s=self.now_s, process=process, text=text) for text in texts]
        self.look(lines=tuple(lines))

    def wait(self, seconds: float, *, hz: float = 0.0, topic: str = "/t", **more: Any) -> None:
        """Look until then; messages come meanwhile at this rate."""
        until_s, next_s = self.now_s + seconds, self.now_s
        while self.now_s < until_s:
            if hz:
                due = []
                while next_s <= self.now_s:
                    due.append(next_s)
                    next_s += 1 / hz
                self.arrive(topic, *due, **more)
            self.look()

    # ---- what came of it

    def changes(self, fault: str) -> list[str]:
        return [change for change, one in self.reports if one["fault"] == fault]

    def states(self) -> dict[str, str]:
        """The state of each fault that is known."""
        reported: dict[str, dict[str, Any]] = {}
        for fault in self.table.faults.values():
            reported[fault.id] = fault.document(lambda at_s: at_s)
        return {name: one["state"] for name, one in reported.items()}

    def fault(self, name: str) -> Fault:
        return self.table.faults[name]

    def only(self) -> Fault:
        """The one fault that there is."""
        (fault,) = self.table.faults.values()
        return fault
