"""The link to a host with systemd."""

from __future__ import annotations

import functools
import time
from collections import deque
from collections.abc import Callable

from launcher.hosts import unit
from launcher.hosts.engine.link import LinkContext, LinkState, beat_s
from launcher.hosts.engine.systemd import journal, run_manifest
from launcher.hosts.engine.systemd.adoption import Adoption
from launcher.hosts.engine.systemd.host_facts import HostFacts, why_unusable
from launcher.hosts.engine.systemd.journal import Entry
from launcher.hosts.engine.systemd.journal_events import JournalEvents
from launcher.hosts.engine.systemd.samples import Samples
from launcher.hosts.engine.systemd.scripts import Scripts, read_properties
from launcher.hosts.engine.systemd.sessions import Sessions
from launcher.hosts.engine.systemd.shell import ScriptRequest, ScriptResult
from launcher.hosts.engine.systemd.unit_process import UnitProcess
from launcher.hosts.engine.timers import Timers
from launcher.hosts.failures import NOT_FOUND, failure
from launcher.hosts.file.order import Order
from launcher.run.processes.machine_events import MachineCommand

LOOK_S = 3.0  # between looks at the states of the units
FINISH_S = 3.0  # for the last lines
READABLE_S = 15.0  # for the first record to come through the journal


def short_id(run_id: str) -> str:
    """The id of a run in the names of its units: without the pid of the launcher."""
    return run_id.rpartition("-")[2]


class SystemdLink:
    """A Link. Its units are started, stopped and restarted by systemd there."""

    def __init__(
        self, context: LinkContext, *, on_unusable: Callable[[str], None] | None = None
    ) -> None:
        self._on_unusable = on_unusable  # in place of GONE, if systemd there cannot be used
        self._context = context
        self._host = context.host
        self._listener = context.listener
        self._reactor = context.reactor
        self._attached = context.attached
        self._started = time.time()
        self._run = short_id(context.run_id) if self._attached is None else self._attached.run
        self._sessions = Sessions(context, self._run, self)
        self._units: dict[int, UnitProcess] = {}
        self._scripts: Scripts
        self._facts: HostFacts
        self._calls: deque[Callable[[], None]] = deque()
        self._events = JournalEvents(self._host.name, self._listener, self._reactor, self._units)
        if self._attached is not None:
            self._adoption = Adoption(
                self._attached,
                self._sessions,
                self._events,
                self._units,
                self._listener,
                self._reactor,
                self._follows,
            )
        self._timers = Timers(self._reactor)
        self._orders: dict[int, Order] = {}
        self._written = 0  # how many of them the record there has
        self._leftovers: tuple[list[str], bool] | None = None
        self._has_watch = self._journal_works = False
        self._samples = Samples()

    # ---- the interface

    @property
    def state(self) -> LinkState:
        return self._sessions.state

    @property
    def silent_s(self) -> float:
        return self._sessions.silent_s

    @property
    def stop_after_s(self) -> float | None:
        policy = self._host.on_link_loss
        return None if policy is None else policy.stop_after_s

    def unit(self, process_id: int) -> str:
        return unit.unit_name(self._run, self._orders[process_id].name)

    def open(self) -> None:
        self._sessions.open()

    def prepare(self, process_id: int, order: Order) -> None:
        self._orders[process_id] = order
        self._call(functools.partial(self._prepare, process_id, order))

    def command(self, process_id: int, command: MachineCommand) -> None:
        if self._attached is not None and command is MachineCommand.START:
            adopt = functools.partial(self._call, self._adopt)
            self._timers.after("adopt", 0, adopt)  # with those that are prepared together
            return
        self._call(lambda: self._units[process_id].command(command))

    def signal(self, process_id: int, signum: int, *, by_user: bool) -> None:
        self._call(lambda: self._units[process_id].signal(signum, by_user=by_user))

    def write_stdin(self, process_id: int, data: bytes) -> None:
        self._call(lambda: self._write_stdin(process_id, data))

    def pause(self, paused: bool) -> None:
        self._events.is_paused = paused
        self._sessions.pause(paused)

    def finish(self, *, at_once: bool) -> None:
        if self.state is LinkState.READY or not at_once:
            self._call(lambda: self._finish(at_once=at_once))
        else:
            self._calls.clear()
            self._sessions.forget_requests()

    def detach(self) -> None:
        if self.stop_after_s is not None:
            raise OSError(f"its processes are stopped {self.stop_after_s:g} s after the launcher")
        if self._calls or self._sessions.has_requests or "manifest" in self._timers:
            if self.state is LinkState.READY:
                raise OSError("it has not got all requests yet; try again")
            raise OSError("it cannot be reached, and has not got all requests: wait until it can")
        if self._facts.is_user and not self._facts.lingers:
            user = self._facts.user
            raise OSError(
                f"its processes would end when {user} logs out;"
                f" there, as root: loginctl enable-linger {user}"
            )

    def close(self) -> None:
        self._sessions.close()
        self._timers.close()
        self._events.close()
        for one in self._units.values():
            one.close()

    # ---- calls wait until the host can be reached

    def _call(self, call: Callable[[], None]) -> None:
        """Not at once: its results must be reported from the event loop."""
        self._calls.append(call)
        self._reactor.call_later(0, self._serve)

    def _serve(self) -> None:
        while self._calls and self.state is LinkState.READY:
            self._calls.popleft()()

    def _request(self, request: ScriptRequest) -> None:
        self._sessions.request(request)

    def _prepare(self, process_id: int, order: Order) -> None:
        name = self._scripts.unit(order.name)
        self._events.by_unit[name] = process_id
        self._units[process_id] = UnitProcess(
            process_id,
            order,
            lambda: self._scripts,
            self._reactor,
            self._request,
            self._listener.event,
            self._when_marked,
            functools.partial(self._listener.warn, self._host.name),
        )
        if self._attached is not None:
            return
        for text in unit.unmet(order.restart, order.stop, self._facts.version):
            if "left out" not in text:
                self._listener.warn(self._host.name, f"{order.name}: {text}")
        self._send_files(process_id, order)
        if self._written != len(self._orders):  # those that were prepared together are in it
            self._written = len(self._orders)
            self._write_manifest()
        if self.stop_after_s is not None and not self._has_watch:
            self._has_watch = True
            self._request(ScriptRequest(self._scripts.watch(self.stop_after_s), self._check_answer))
            self._timers.every("beat", beat_s(self.stop_after_s), self._send_beat)

    def _write_manifest(self) -> None:
        document = run_manifest.encode(self._run, self._context.title, self._started, self._orders)
        self._request(ScriptRequest(self._scripts.manifest(document), self._check_answer))

    def _send_files(self, process_id: int, order: Order) -> None:
        self._request(ScriptRequest(self._scripts.files(process_id, order), self._check_answer))

    def _check_answer(self, answer: ScriptResult) -> None:
        if answer.code:
            lines = answer.text.strip().splitlines() or [f"exit code {answer.code}"]
            self._listener.warn(self._host.name, f"cannot prepare its processes: {lines[-1]}")

    def _send_beat(self) -> None:
        self._sessions.send_beat(self._scripts.beat())

    def _write_stdin(self, process_id: int, data: bytes) -> None:
        name = self._units[process_id].order.name

        def answered(answer: ScriptResult) -> None:
            if answer.code:
                text = f"{name}: cannot write to its standard input: it does not read"
                self._listener.warn(self._host.name, text)

        script = self._scripts.write_stdin(process_id, data)
        self._request(ScriptRequest(script, answered, lasts=False))

    # ---- the sessions

    def met(self, facts: HostFacts) -> str | None:
        why_not = why_unusable(facts)
        if why_not and self._on_unusable is not None:
            self._on_unusable(why_not)
            return None
        if why_not:
            return f"{why_not}, or set `engine: ssh` for it in the hosts file"
        if facts.lacks_python:
            return failure(self._host, "", NOT_FOUND).cause
        if not facts.has_launcher:
            return (
                f"its Python '{self._host.python}' does not have the launcher; install it there"
                " (python -m launcher hosts sync), or set `python:` in the hosts file"
            )
        self._know(facts)
        if facts.is_user and not facts.lingers:
            text = (
                f"processes of {facts.user} end some seconds after the connection does; to keep"
                f" them, run there as root: loginctl enable-linger {facts.user}"
            )
            self._warn_later(text)
        name = unit.installed_name(self._context.title.partition(" ")[0])
        if self._attached is None and name in facts.installed:
            self._warn_later(
                f"{name}.target is installed there (--enable): what it starts runs beside this run;"
                " --disable removes it"
            )
        return ""

    def _warn_later(self, text: str) -> None:
        self._reactor.call_later(0, lambda: self._listener.warn(self._host.name, text))

    def _know(self, facts: HostFacts) -> None:
        self._facts = facts
        self._events.uid = facts.uid
        self._scripts = Scripts(self._run, self._host, facts)

    def met_again(self, facts: HostFacts) -> bool:
        if facts.boot_id == self._facts.boot_id:
            if self._has_watch:
                self._send_beat()
            return True
        if self._attached is not None:
            self._sessions.give_up("it was restarted, which has ended its processes")
            return False
        self._know(facts)
        lost = [one.order.name for one in self._units.values() if one.machine.is_pending]
        fate = f"; its processes are lost: {', '.join(lost)}" if lost else ""
        self._listener.warn(self._host.name, f"was restarted{fate}")
        now = self._reactor.now()
        self._sessions.reader.cursor = facts.cursor
        for one in self._units.values():
            one.lost(now)
        self._restore()
        return False

    def _restore(self) -> None:
        """Runtime files do not survive a restart of the host."""
        self._request(ScriptRequest(self._scripts.prepare(), self._check_answer))
        for process_id, one in self._units.items():
            self._send_files(process_id, one.order)
        if self._has_watch and self.stop_after_s is not None:
            self._request(ScriptRequest(self._scripts.watch(self.stop_after_s), self._check_answer))

    def changed(self, state: LinkState, reason: str) -> None:
        is_first = state is LinkState.READY and not self._journal_works
        if is_first:
            self._timers.every("look", LOOK_S, self._look)
            if self._attached is None:
                self._request(ScriptRequest(self._scripts.prepare(), self._check_answer))
                self._await_first()
        for one in self._units.values():
            if state is LinkState.READY:
                one.resume_timers()
            else:
                one.suspend_timers()
        self._listener.link_changed(self._host.name, state, reason)
        self._reactor.call_later(0, self._serve)

    def _await_first(self) -> None:
        self._request(ScriptRequest(self._scripts.mark("first"), lasts=False))
        self._timers.after("readable", READABLE_S, self._check_readable)

    def _check_readable(self) -> None:
        if not self._journal_works and self.state is LinkState.READY:
            text = (
                f"{self._facts.user} cannot read the lines of processes in the journal; run there"
                f" as root: usermod --append --groups systemd-journal {self._facts.user}"
            )
            self._listener.warn(self._host.name, text)

    def mark(self, token: str) -> str:
        return self._scripts.mark(token)

    # ---- the journal

    def entry(self, entry: Entry) -> None:
        self._journal_works = True
        at_s = self._sessions.clock.here(entry.monotonic_s, self._reactor.now())
        self._events.feed(entry, at_s)

    def missed(self) -> None:
        text = "its journal was rotated before all was read: lines of processes may be lost"
        self._listener.warn(self._host.name, text)

    def _when_marked(self, callback: Callable[[], None]) -> None:
        """Call back when all entries of the journal so far have been read, or none come."""
        token = journal.new_mark()
        self._events.when_marked(token, callback)
        self._request(ScriptRequest(self._scripts.mark(token)))

    # ---- attaching

    def _adopt(self) -> None:
        self._adoption.begin(self._scripts, self._facts)

    def _follows(self) -> None:
        self._await_first()
        self._when_marked(self._events.end_past)  # if nothing new is before it

    # ---- looking

    def _look(self) -> None:
        """What is missing in the journal, and the resources."""
        if self.state is not LinkState.READY or not self._units:
            return
        names = [one.order.name for one in self._units.values()]
        self._request(ScriptRequest(self._scripts.show(names), self._looked, lasts=False))
        pids = {i: one.pid for i, one in self._units.items() if one.pid > 0}
        if pids:
            script = self._samples.script(pids.values(), self._reactor.now())
            self._request(
                ScriptRequest(script, functools.partial(self._sampled, pids), lasts=False)
            )

    def _looked(self, answer: ScriptResult) -> None:
        if self.state is not LinkState.READY:
            return
        now = self._reactor.now()
        for found in read_properties(answer.text):
            process_id = self._events.by_unit.get(found.get("Id", ""))
            if process_id is not None:
                self._units[process_id].seen(found, now)

    def _sampled(self, pids: dict[int, int], answer: ScriptResult) -> None:
        found = self._samples.read(answer.text, pids, self._reactor.now())
        if found:
            self._listener.samples(self._host.name, found)

    # ---- the end

    def _finish(self, *, at_once: bool) -> None:
        names = [one.order.name for one in self._units.values()]
        answered = functools.partial(self._finish_answered, at_once)
        script = self._scripts.finish(names, run_manifest.operator(), at_once=at_once)
        self._request(ScriptRequest(script, answered))
        self._when_marked(self._finished)

    def _finish_answered(self, at_once: bool, answer: ScriptResult) -> None:
        left = [line for line in answer.text.splitlines() if line.startswith("launcher-")]
        self._leftovers = left, at_once and bool(left)
        self._timers.after("finish", FINISH_S, self._finished)

    def _finished(self) -> None:
        if self._leftovers is not None:
            (left, killed), self._leftovers = self._leftovers, None
            self._timers.cancel("finish")
            self._events.give_up_limbo()
            self._listener.finished(self._host.name, left, killed=killed)
