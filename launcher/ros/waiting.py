"""Waits until processes of a run are in a state, and until the ROS graph has what is named."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

from launcher.base.model.supervision import Fact
from launcher.control.active_runs import ListedRun, NoActiveRunError, find_run
from launcher.control.client import Connection, NoRunError, RefusedError
from launcher.posix.domains import environment_domain
from launcher.posix.reactor import Reactor
from launcher.posix.socket_directory import ControlError
from launcher.ros.discovery.run_settings import adopt
from launcher.run.helpers.graph_facts import GraphFacts

STATES = ("running", "ready", "ended")
LOOK_S = 0.1  # from one search for a run, of which nothing announces the begin, to the next
_OVER = ("STOPPED", "EXITED", "FATAL")


class Awaited:
    """One thing that is waited for: `wanted` of `name`; `text` is what is seen instead."""

    def __init__(self, name: str, wanted: str, text: str) -> None:
        self.name = name
        self.wanted = wanted
        self.holds = False
        self.is_lost = False  # it can no longer hold
        self._was_there = False
        self.text = text

    def document(self) -> dict[str, object]:
        return {"name": self.name, "wanted": self.wanted, "holds": self.holds, "text": self.text}

    def look(self, rows: Sequence[dict[str, Any]]) -> None:
        """Compare the processes that the name stands for, as rows of `ps`."""
        self._was_there = True
        others = [row for row in rows if not _is(row, self.wanted)]
        self.holds = not others
        described = _described if others or self.wanted == "ended" else self._as_wanted
        self.text = "; ".join(map(described, others or rows))
        self.is_lost = self.wanted != "ended" and any(map(_is_over, others))

    def _as_wanted(self, row: dict[str, Any]) -> str:
        return f"{row['name']} is {self.wanted}"

    def end(self) -> None:
        """The run has ended, and all of its processes."""
        if self.holds and self.wanted == "ended":
            return
        self.holds = self.wanted == "ended" and self._was_there
        self.is_lost = not self.holds
        without = "" if self._was_there else f" without a process '{self.name}'"
        self.text = (
            f"{self.name} has ended with its run" if self.holds else f"the run has ended{without}"
        )


def _is(row: dict[str, Any], wanted: str) -> bool:
    if wanted == "ended":
        return _is_over(row)
    is_ready = wanted == "running" or row.get("ready") in (None, True)
    return row["state"] == "RUNNING" and is_ready


def _is_over(row: dict[str, Any]) -> bool:
    """Whether it has ended, and nothing will start it again; not one that waits for its start."""
    return row["state"] == "FATAL" or (row["state"] in _OVER and row["last_exit"] is not None)


def _described(row: dict[str, Any]) -> str:
    """`robot_2-3 is running: no publisher on /fleet/status (2.1 s)`."""
    ended = row["last_exit"]
    if _is_over(row):
        how = f" ({ended['text']})" if ended else ""
        return f"{row['name']} has ended{how}"
    missing = row.get("lacks") or row.get("waiting_for")
    return f"{row['name']} is {row['state'].lower()}" + (f": {missing}" if missing else "")


class ConditionWait:
    """Waits in `reactor` for all conditions. Close it, or use `with`.

    A process is looked at whenever its run reports an event. A fact of the graph that was seen
    once holds.
    """

    def __init__(
        self,
        reactor: Reactor,
        names: Sequence[str],
        state: str,
        facts: Sequence[Fact],
        run: str | None = None,
    ) -> None:
        self._reactor = reactor
        self._which = run
        self._facts = facts
        whose = f"no run {run}" if run else "no run"
        self._of_run = [
            Awaited(name, state, f"{whose} has a process '{name}' yet") for name in names
        ]
        unseen = f"the domain is that of the run: {whose} yet" if names else "none yet"
        self._of_graph = [
            Awaited(one.subject, one.kind, f"{one.kind} {one.subject}: {unseen}") for one in facts
        ]
        self._graph = GraphFacts(reactor, lambda text: None)
        self._events: Connection | None = None
        self._rows: Connection | None = None
        self.changed: Callable[[], object] = lambda: None  # called after each look
        # Called for a name that looks like a misspelt one, which may never come.
        self.suspect: Callable[[Awaited], object] = lambda condition: None

    @property
    def conditions(self) -> list[Awaited]:
        return [*self._of_run, *self._of_graph]

    def __enter__(self) -> ConditionWait:
        return self

    def __exit__(self, *exc: object) -> None:
        self._graph.close()
        for connection in (self._events, self._rows):
            if connection is not None:
                connection.close()

    def begin(self) -> None:
        """Look for the run first: its nodes are in its domain. ControlError."""
        if not self._of_run:
            self._watch()
        elif (run := self._found()) is not None:
            self._follow(run)
        else:
            self._reactor.call_later(LOOK_S, self.begin)

    def _found(self) -> ListedRun | None:
        """The run; None if it has not begun. ControlError if there are several."""
        try:
            return find_run(self._which)
        except NoActiveRunError:
            return None

    def _watch(self) -> None:
        env = dict(os.environ, ROS_DOMAIN_ID=str(environment_domain()))
        for fact, condition in zip(self._facts, self._of_graph, strict=True):
            condition.text = f"no {fact.kind} {fact.subject} yet"
            self._graph.watch(fact, env, 0.0, self._reporter(condition))

    def _reporter(self, condition: Awaited) -> Callable[[bool, str], None]:
        def report(holds: bool, text: str) -> None:
            condition.holds = holds
            is_there = f"{condition.wanted} {condition.name} is there"
            condition.text = is_there if holds else text
            self.changed()

        return report

    # ---- the run

    def _follow(self, run: ListedRun) -> None:
        if run.domain_id is not None:
            os.environ["ROS_DOMAIN_ID"] = str(run.domain_id)
            adopt(os.environ, environment_domain)
        try:
            self._events, self._rows = run.connect(), run.connect()
            self._events.send("events", follow=True, history=False)
        except NoRunError:
            self._end()
            return
        self._watch()
        self._reactor.add_reader(self._events.fileno(), self._happened)
        self._look()

    def _happened(self) -> None:
        assert self._events is not None
        try:
            self._events.read()
            while self._events.has_line:
                self._events.read()
        except ControlError:
            self._end()
            return
        self._look()

    def _look(self) -> None:
        assert self._rows is not None
        for condition in self._of_run:
            try:
                condition.look(self._rows.ask("ps", [condition.name]).result["processes"])
            except RefusedError as error:
                condition.holds = False
                condition.text = error.message + (f" ({error.hint})" if error.hint else "")
                if error.hint and "did you mean" in error.hint:
                    self.suspect(condition)
            except NoRunError:
                return  # its events end as well
        self.changed()

    def _end(self) -> None:
        if self._events is not None:
            self._reactor.remove(self._events.fileno())
        for condition in self._of_run:
            condition.end()
        self.changed()
