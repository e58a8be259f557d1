"""Attaching to a run: its processes are taken as they are, its journal from the last lines on."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from launcher.hosts.engine.link import Attached, LinkListener
from launcher.hosts.engine.systemd import journal
from launcher.hosts.engine.systemd.host_facts import HostFacts
from launcher.hosts.engine.systemd.journal_events import JournalEvents
from launcher.hosts.engine.systemd.scripts import Scripts, read_properties
from launcher.hosts.engine.systemd.sessions import Sessions
from launcher.hosts.engine.systemd.shell import ScriptRequest, ScriptResult
from launcher.hosts.engine.systemd.unit_process import UnitProcess
from launcher.posix.reactor import Reactor


class Adoption:
    """The journal is followed only when it is known whose lines may come; then `follows`."""

    def __init__(
        self,
        attached: Attached,
        sessions: Sessions,
        events: JournalEvents,
        units: Mapping[int, UnitProcess],
        listener: LinkListener,
        reactor: Reactor,
        follows: Callable[[], None],
    ) -> None:
        self._attached = attached
        self._sessions = sessions
        self._events = events
        self._units = units
        self._listener = listener
        self._reactor = reactor
        self._follows = follows

    def begin(self, scripts: Scripts, facts: HostFacts) -> None:
        """Ask the host for the states of all units; call it when all of them are known here."""
        self._facts = facts
        states = scripts.show(one.order.name for one in self._units.values())
        self._sessions.request(ScriptRequest(states, self._adopt))

    def _adopt(self, answer: ScriptResult) -> None:
        now = self._reactor.now()
        clock = self._sessions.clock
        self._events.begin(clock.there(now))
        for found in read_properties(answer.text):
            process_id = self._events.by_unit.get(found.get("Id", ""))
            if process_id is None:
                continue
            one = self._units[process_id]
            since_s = int(found.get("ExecMainStartTimestampMonotonic") or 0) / 1e6
            since_s = clock.here(since_s, now)
            state = one.adopt(found, since_s)
            restarts = one.machine.restarts
            self._listener.adopted(process_id, state, one.pid, since_s, restarts)
        uid = self._facts.uid
        announced = [number for number, one in self._units.items() if uid or not one.order.merge]
        past = journal.past(self._attached.run, self._attached.lines, uid, announced)
        self._sessions.request(ScriptRequest(past, self._follow))

    def _follow(self, answer: ScriptResult) -> None:
        notes, lines, first = journal.read_past(
            self._attached.run, answer.text, self._events.begin_s
        )
        for note in notes:
            self._events.feed(note, self._reactor.now())
        for line in lines:
            self._events.announces(line)
        for process_id, one in self._units.items():
            if one.pid > 0:
                self._events.started(process_id, one.pid)
        self._sessions.follow(behind=self._facts.cursor if first is None else None, first=first)
        self._follows()
