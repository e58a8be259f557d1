"""Which nodes do not answer, as `launcher.ros.helpers.responsiveness` reports, a helper process.

It is running while somebody looks (`top`, the server of `--web`), or during the whole run with
`--responsive`, one for each ROS domain: it takes 30 MB and a participant in the domain. In a
watched run it goes on while a node that it has reported does not answer.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence

from launcher.base.model.ros_arguments import full_node_name
from launcher.base.model.run_events import NotResponding, Responds
from launcher.posix import proc
from launcher.posix.reactor import Timer
from launcher.run.helpers.helper_programs import RESPONSIVENESS
from launcher.run.helpers.json_lines import JsonLinesProcess, own_end, without_shared_memory
from launcher.run.part import Part
from launcher.run.processes.machine_events import ProcessState
from launcher.run.processes.process import Process, Silence
from launcher.run.stacks.dump import Dump, lines
from launcher.run.stacks.stacks import DumpRequest, Stacks, members

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.run import Run

    Unanswered = dict[str, Any]  # `name`, whether it was `asked`, and the `reason`

PERIOD_S = 1.0
LOOK_S = 15.0  # after the last look the helper goes on for so long
ASK_S = 10.0  # its start takes a second, discovery up to three, and silence is noticed after three
GOODBYE_S = 2.0
SURE_S = 4.5  # silence is noticed after 3 s, by a round each second
POLL_S = 0.1


class Responsiveness(Part):
    """Which nodes of the run answer, while somebody looks."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._reactor = run.reactor
        self._log = run.log
        self._processes = run.all_processes
        self._until_s = -math.inf
        self._is_asked = False
        self._timer: Timer | None = None
        # By domain; None: it does not work there.
        self._helpers: dict[str, JsonLinesProcess | None] = {}
        self._sent: dict[str, list[dict[str, Any]]] = {}
        # By name of the process: the pid of its last life that has answered.
        self._answered: dict[str, int] = {}

    def begin(self) -> None:
        if not self.run.shutdown.has_begun:
            self.look(math.inf)

    def look(self, for_s: float = LOOK_S) -> None:
        """Somebody looks now; `inf`: to the end of the run."""
        self._until_s = max(self._until_s, self._reactor.now() + for_s)
        if self._timer is None:
            self._tick()

    def ask(self, processes: Sequence[Process], done: Callable[[list[Unanswered]], None]) -> None:
        """Call `done` when it is known which of these answer, with those of which that is unknown.

        One that has not answered before is not responding if its services are there, unless it is
        watched during the whole run: then it may be starting.
        """
        self._is_asked = self._until_s != math.inf
        now = self._reactor.now()
        # What is known already may be older than a silence that is not noticed yet.
        since_s = now if self._timer is None else now + SURE_S
        self.look()
        self._look_again(processes, since_s, now + ASK_S, done)

    def _look_again(
        self,
        processes: Sequence[Process],
        since_s: float,
        until_s: float,
        done: Callable[[list[Unanswered]], None],
    ) -> None:
        now = self._reactor.now()
        unanswered = self._unanswered(processes)
        is_open = any(one["asked"] for one in unanswered) and now < until_s
        if (now < since_s or is_open) and self._timer is not None:
            again = functools.partial(self._look_again, processes, since_s, until_s, done)
            self._reactor.call_later(POLL_S, again)
        else:
            done(unanswered)

    def _unanswered(self, processes: Sequence[Process]) -> list[Unanswered]:
        """Those of the running ones that neither answer nor are silent, and why."""
        asked = {p: d for d, nodes in self._wanted().items() for p in nodes.values()}
        found: list[Unanswered] = []
        for process in processes:
            if process.machine.state is not ProcessState.RUNNING:
                continue
            is_asked = process in asked and self._helpers.get(asked[process], self) is not None
            if is_asked and (process.answers or process.silence is not None):
                continue
            if is_asked:
                is_same = process.child and self._answered.get(process.name) == process.child.pid
                reason = "does not answer any more" if is_same else "has never answered"
            elif process in asked:
                reason = "the program that asks is not running"
            else:
                reason = _why_unasked(process)
            found.append({"name": process.name, "asked": is_asked, "reason": reason})
        return found

    def _tick(self) -> None:
        if self._reactor.now() > self._until_s:
            if not self._is_awaited():
                self.end_helpers()
                return
            self._is_asked = False
        wanted = self._wanted()
        for domain in wanted.keys() - self._helpers.keys():
            env = next(iter(wanted[domain].values())).spec.env
            self._helpers[domain] = self._started(domain, env)
        for domain, helper in self._helpers.items():
            if helper is not None and not helper.has_unsent:
                self._send(helper, domain, wanted.get(domain, {}))
        self._forget_others(wanted)
        self._timer = self._reactor.call_later(PERIOD_S, self._tick)

    def _is_awaited(self) -> bool:
        """Whether a fault of a watched run is open, which heals when its node answers."""
        options = self.run.options
        is_watched = options.watchful or options.expect is not None
        silent = (one for one in self._processes.values() if one.silence is not None)
        return is_watched and any(map(_should_answer, silent))

    def _send(self, helper: JsonLinesProcess, domain: str, nodes: Mapping[str, Process]) -> None:
        """What it watches, if that has changed.

        Nodes that are expected to answer are reported even if they never have.
        """
        entries = [
            {"name": one.name, "pid": one.child.pid, "node": node, "expected": self._is_asked}
            for node, one in nodes.items()
            if one.child is not None
        ]
        if entries != self._sent.get(domain):
            self._sent[domain] = entries
            helper.send(entries)

    def _wanted(self) -> dict[str, dict[str, Process]]:
        """Domain -> full name of the node -> its process, for all that should answer."""
        found: dict[str, dict[str, Process]] = {}
        for process in self._processes.values():
            node = full_node_name(process.spec.argv) if _should_answer(process) else None
            if node is not None:
                domain = process.spec.env.get("ROS_DOMAIN_ID") or "0"
                found.setdefault(domain, {})[node] = process
        return found

    def _forget_others(self, wanted: Mapping[str, Mapping[str, Process]]) -> None:
        """Those that were suspended, or restarted under a debugger, are not expected to answer."""
        names = {process.name for nodes in wanted.values() for process in nodes.values()}
        for process in self._processes.values():
            if process.name not in names and process.machine.state is ProcessState.RUNNING:
                process.answers, process.silence = False, None

    def _started(self, domain: str, env: Mapping[str, str]) -> JsonLinesProcess | None:
        env = without_shared_memory(own_end(env))
        ended = functools.partial(self._ended, domain)
        try:
            helper = JsonLinesProcess(
                self._reactor, RESPONSIVENESS, env, on_message=self._report, on_end=ended
            )
        except OSError as error:
            self._log.warn(f"it is not watched whether nodes respond: {error.strerror}")
            return None
        self.run.housekeeper.ledger.helper_pids.add(helper.pid)
        return helper

    def _ended(self, domain: str, code: int, why: str) -> None:
        self._helpers[domain] = None
        self._log.warn(f"it is not watched any more whether nodes respond: {why or 'no reason'}")
        self._forget_others({})

    def _report(self, report: dict[str, Any]) -> None:
        process = next((p for p in self._processes.values() if p.name == report["name"]), None)
        if process is None or process.child is None or process.child.pid != report["pid"]:
            return
        if not _should_answer(process):
            return
        now, silent_s = self._reactor.now(), report["silent_s"]
        if silent_s is None:
            process.answers, process.silence = False, None
        elif not silent_s:
            self._answers(process, now)
        elif process.silence is not None:
            process.silence.report(silent_s, now)
        elif not any(map(proc.is_traced, members(process.child.pid))):
            self._fell_silent(process, report, now)

    def _answers(self, process: Process, now: float) -> None:
        process.answers, silence, process.silence = True, process.silence, None
        if process.child is not None:
            self._answered[process.name] = process.child.pid
        if silence is not None:
            silent_s = silence.elapsed_s(now)
            self._log.log("INFO", process.name, f"responds again, after {silent_s:.0f} s")
            self._log.note(Responds(round(silent_s, 1)), process)

    def _fell_silent(self, process: Process, report: dict[str, Any], now: float) -> None:
        assert process.child is not None
        silence = process.silence = Silence()
        silence.report(report["silent_s"], now)
        self._log.note(NotResponding(report["silent_s"]), process)

        def found(dump: Dump) -> None:
            silence.stack = tuple(lines(dump))
            where = f"it is in {dump.place}" if dump.place else _state(dump)
            text = f"{report['node']} has not answered for {silence.elapsed_s(now):.0f} s"
            self._log.log("WARNING", process.name, f"does not respond: {text}; {where}")

        self.run.parts.need(Stacks).dump(DumpRequest(members(process.child.pid)[0]), found)

    def end_helpers(self) -> None:
        """Nobody looks any more, or the run has ended."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        self._until_s, self._is_asked = -math.inf, False
        for helper in self._helpers.values():
            if helper is not None:
                helper.close(GOODBYE_S)
        self._helpers.clear()
        self._sent.clear()
        self._forget_others({})


def _should_answer(process: Process) -> bool:
    """Whether it runs here, and neither a user nor a debugger holds it."""
    is_running = process.child is not None and process.machine.state is ProcessState.RUNNING
    is_held = process.machine.is_suspended or process.debugger is not None
    return is_running and not is_held and process.host is None


def _why_unasked(process: Process) -> str:
    """Of one that is running."""
    if process.host is not None:
        return "on another host"
    if full_node_name(process.spec.argv) is None:
        return "no node name in the launch file"
    if process.machine.is_suspended:
        return "paused"
    if process.debugger is not None:
        return "under a debugger"
    return "another process has the same node name"


def _state(dump: Dump) -> str:
    state = dump.threads[0].state if dump.threads else "its state is not known"
    return f"{state} ({dump.problem})" if dump.problem else state
