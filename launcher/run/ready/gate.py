"""Holds back the first start of processes until those that they wait for are ready."""

from __future__ import annotations

import errno
import functools
from collections.abc import Mapping, Sequence

from launcher.base.model import run_events
from launcher.base.model.supervision import StartRule
from launcher.base.text import several
from launcher.posix.reactor import Timer
from launcher.run.part import StartStage
from launcher.run.processes.machine_events import MachineCommand, ProcessState
from launcher.run.processes.process import Process
from launcher.run.ready import start_order
from launcher.run.ready.ready_watch import ReadyWatch
from launcher.run.ready.start_order import StartOrder
from launcher.run.ready.waiting_process import StartPhase

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.run_options import RunOptions
    from launcher.run.helpers.graph_facts import GraphFacts
    from launcher.run.processes.machine_events import ReportExit
    from launcher.run.run import Run

REPORT_EVERY_S = 10.0  # which processes still wait
MAX_NAMES = 3  # of processes in such a line


class ReadyGate(StartStage):
    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._reactor = run.reactor
        self._log = run.log
        self._order = StartOrder(run.options.start_rules, run.launched.switched_off)
        self._processes: dict[str, Process] = {}
        self._watches: dict[str, ReadyWatch] = {}
        self._timer: Timer | None = None
        self._reported_s = 0.0
        self._is_closed = False
        self._graph: GraphFacts | None = None

    # ---- the gate

    def adding(self, process: Process) -> None:
        self._processes[process.name] = process
        self._carry_out(self._order.add(process.spec))
        self._set_facts(process)

    def _set_facts(self, process: Process) -> None:
        process.awaited_facts = tuple(fact.text for fact in self._order[process.name].facts)

    def _join(self, process: Process) -> None:
        """A process from before there were rules: it does not wait."""
        self.adding(process)
        now = self._reactor.now()
        self._order.skip(process.name, now)
        if process.history.starts:
            self._carry_out(self._order.started(process.name, now))
        if process.child is not None:
            self._watch(process)
        elif process.last_end is not None:
            self.ended(process, process.last_end)

    def follow(self, before: RunOptions) -> None:
        """Other rules may hold from now on."""
        if self.run.options.start_rules == before.start_rules:
            return
        self._follow(self.run.options.start_rules)
        for process in self.run.processes:
            if process.name not in self._processes:  # from before there were rules
                self._join(process)

    def _follow(self, rules: Sequence[StartRule]) -> None:
        before = {name: self._order[name].facts for name in self._processes}
        self._carry_out(self._order.follow(rules, self._reactor.now()))
        for name, process in self._processes.items():
            if self._order[name].facts != before[name]:
                self._set_facts(process)
                self._unwatch(name)
                self._watch(process)
        self._check_soon()

    def adopted(self, process: Process) -> None:
        self._carry_out(self._order.adopt(process.spec))
        self._set_facts(process)
        self._check_soon()

    def dropped(self, process: Process) -> None:
        if process.name not in self._processes:
            return
        self._unwatch(process.name)
        del self._processes[process.name]
        self._order.forget(process.name)
        self._check_soon()

    def waits(self, process: Process) -> bool:
        return self._order[process.name].phase is StartPhase.WAITING

    def admit(self, process: Process) -> None:
        entry, now = self._order[process.name], self._reactor.now()
        if process.machine.is_held:  # a user starts it
            self._order.skip(process.name, now)
        if self._order.admit(process.name, now):
            self.pass_on(process)
            self._check_soon()  # others may wait for those that wait
            return
        after = entry.rule.after
        assert after is not None
        names = ", ".join(after.names)
        text = f"waiting for {names}, at most {after.timeout_s:g} s"
        self._log.log("INFO", process.name, text)
        self._log.note(run_events.Waiting(tuple(after.names), after.timeout_s), process)
        self._reported_s = max(self._reported_s, now)
        self._check_soon()  # not now: the launch file may start more of them

    def withdraw(self, process: Process) -> bool:
        if not self._order.withdraw(process.name):
            return False
        self._check_soon()
        return True

    def skip(self, process: Process) -> None:
        entry, now = self._order[process.name], self._reactor.now()
        waited_s = now - entry.admitted_s
        if self._order.skip(process.name, now):
            self._note_release(process, waited_s, "requested")
            self.pass_on(process)

    # ---- what happens to processes

    def started(self, process: Process) -> None:
        self._carry_out(self._order.started(process.name, self._reactor.now()))
        self._watch(process)
        self._check_soon()

    def _watch(self, process: Process) -> None:
        """Look for the facts of a running process that is not ready."""
        entry = self._order[process.name]
        if entry.is_running and entry.facts and entry.ready_s is None:
            self._watches[process.name] = ReadyWatch(
                process,
                entry.facts,
                functools.partial(self._seen, process.name),
                reactor=self._reactor,
                graph=self._graph_facts,
                env=self._env_of(process),
            )

    def _env_of(self, process: Process) -> Mapping[str, str]:
        if process.host is not None:
            return self.run.agent_env
        return self.run.spawner.settings_of(process, process.spec).env

    def ended(self, process: Process, end: ReportExit) -> None:
        if process.name not in self._processes:
            return  # it is gone, and could not be ended before
        outcome = end.outcome
        actions = self._order.ended(
            process.name,
            self._reactor.now(),
            outcome.returncode,
            str(outcome),
            asked=end.asked,
            final=end.is_final,
        )
        self._unwatch(process.name)
        self._carry_out(actions)
        self._check_soon()

    def _seen(self, name: str, index: int, holds: bool, text: str) -> None:
        now = self._reactor.now()
        actions = self._order.fact(name, index, now, holds=holds, text=text)
        if actions:
            self._unwatch(name)
            self._carry_out(actions)
            self._check_soon()

    def _unwatch(self, name: str) -> None:
        if name in self._watches:
            self._watches.pop(name).close()

    def _graph_facts(self) -> GraphFacts:
        """Imported, and its process started, when a fact needs the ROS graph."""
        if self._graph is None:
            from launcher.run.helpers.graph_facts import GraphFacts

            self._graph = GraphFacts(self._reactor, self._log.warn)
        return self._graph

    # ---- waiting

    def _check_soon(self) -> None:
        self._wake_in(0)

    def _wake_in(self, delay_s: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = None if self._is_closed else self._reactor.call_later(delay_s, self._check)

    def _check(self) -> None:
        self._timer = None
        actions = self._order.check(self._reactor.now())
        self._carry_out(actions)
        if actions:
            self.run.idle()
        if not self._order.waiting:
            return
        self._report()
        now = self._reactor.now()
        deadline = self._order.deadline
        due_s = self._reported_s + REPORT_EVERY_S
        wake_s = due_s if deadline is None else min(due_s, deadline)
        if self._timer is None:
            self._wake_in(max(0.0, wake_s - now))

    def _report(self) -> None:
        """Say now and then who still waits for what."""
        now = self._reactor.now()
        if now < self._reported_s + REPORT_EVERY_S:
            return
        self._reported_s = now
        names: dict[str, list[str]] = {}
        for entry in self._order.waiting:
            names.setdefault(self._order.reason(entry.name), []).append(entry.name)
        for reason, those in names.items():
            listed = several(those, MAX_NAMES)
            waited_s = now - min(self._order[name].admitted_s for name in those)
            verb = "waits" if len(those) == 1 else "wait"
            text = f"{listed} {verb} for {reason} ({waited_s:.1f} s)"
            self._log.log("INFO", "launch", text)

    def _carry_out(self, actions: Sequence[start_order.Action]) -> None:
        for action in actions:
            process = self._processes[action.name]
            match action:
                case start_order.ReleaseStart(waited_s=waited_s):
                    self._note_release(process, waited_s, "ready")
                    self.pass_on(process)
                case start_order.Expire():
                    self._expire(process, action)
                case start_order.ReportReady(took_s=took_s):
                    self._log.log("INFO", process.name, f"ready after {took_s:.2f} s")
                    self._log.note(run_events.Ready(round(took_s, 6)), process)
                case start_order.RestartWith(other=other):
                    self._restart(process, other)
                case start_order.Circle(chain=chain):
                    text = f"does not wait, since that would be a circle: {' -> '.join(chain)}"
                    self._log.log("WARNING", process.name, text)

    def _restart(self, process: Process, other: str) -> None:
        """The launch file gets no event of its exit: `on_exit` must not end the run."""
        if process.machine.state is ProcessState.RUNNING and not process.is_debugged:
            text = f"restarted, since {other} has been restarted"
            self._log.log("INFO", process.name, text)
            process.is_replaced = True
            self.run.driver.advance(process, MachineCommand.RESTART)

    def _expire(self, process: Process, expired: start_order.Expire) -> None:
        what = f"not ready after {expired.waited_s:.1f} s: {expired.text}"
        if expired.consequence == "start":
            self._log.log("WARNING", process.name, f"started although {what}")
            self._note_release(process, expired.waited_s, "timeout")
            self.pass_on(process)
            return
        self._note_release(process, expired.waited_s, expired.consequence)
        self.run.driver.refuse(process, errno.ETIMEDOUT, f"waited for {what}")
        if expired.consequence == "stop-run":
            self.run.shutdown.stop(f"{process.name} has waited for {expired.text}")

    def _note_release(self, process: Process, waited_s: float, why: str) -> None:
        names = tuple(self._order.needed(process.name))
        self._log.note(run_events.Released(round(waited_s, 6), why, names), process)

    # ---- for users

    def row(self, process: Process) -> dict[str, object]:
        """`ready` is None for a process without `ready_when`."""
        if process.name not in self._processes:
            return {"ready": None, "ready_s": None, "waiting_for": None, "lacks": None}
        entry, now = self._order[process.name], self._reactor.now()
        reason = self._order.reason(process.name)
        waits = entry.phase is StartPhase.WAITING
        since_s = entry.admitted_s if waits else entry.started_s
        text = f"{reason} ({now - since_s:.1f} s)" if reason else None
        is_ready = entry.ready_s is not None
        return {
            "ready": is_ready if entry.facts else None,
            "ready_s": round((entry.ready_s or 0.0) - entry.started_s, 3)
            if is_ready and entry.facts
            else None,
            "waiting_for": text if waits else None,
            "lacks": None if waits else text,
        }

    def end_helpers(self) -> None:
        self._is_closed = True
        if self._timer is not None:
            self._timer.cancel()
        for name in list(self._watches):
            self._unwatch(name)
        if self._graph is not None:
            self._graph.close()
