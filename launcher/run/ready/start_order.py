"""Which processes wait for which, and when they are ready, without I/O.

Time is an argument (seconds on the monotonic clock). The methods return the actions that the driver
has to carry out; `deadline` is when it has to call `check`.

    NEW --admit--> WAITING --its processes are ready, timeout, a user--> PASSED
                      |
                      +--withdraw--> NEW

A process is ready when all facts of its `ready_when` have held in its present life, without any
when it runs, and stays ready until it ends; if it then exits with code 0 by itself, it has done
what others waited for. Only the first start of a process waits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from launcher.base.model.record import Record, replace
from launcher.base.model.run_options import matches
from launcher.base.model.spec import ProcessSpec
from launcher.base.model.supervision import StartRule, circle, rule_for
from launcher.run.ready.waiting_process import StartPhase, WaitingProcess


class ReleaseStart(Record):
    """Let it start, after a wait of so many seconds."""

    name: str
    waited_s: float


class Expire(Record):
    """It has waited in vain: `consequence` is due, `text` is the reason."""

    name: str
    consequence: str
    text: str
    waited_s: float


class ReportReady(Record):
    """It is ready, so many seconds after its start."""

    name: str
    took_s: float


class RestartWith(Record):
    """Restart it: `other` has been restarted."""

    name: str
    other: str


class Circle(Record):
    """It does not wait, since that would be a circle: the names in it."""

    name: str
    chain: tuple[str, ...]


Action = ReleaseStart | Expire | ReportReady | RestartWith | Circle


class StartOrder:
    """The processes of a run. `switched_off` are those that a condition keeps away."""

    def __init__(
        self,
        rules: Sequence[StartRule],
        switched_off: Callable[[], Iterable[ProcessSpec]] = lambda: (),
    ) -> None:
        self._rules = rules
        self._switched_off = switched_off
        self._entries: dict[str, WaitingProcess] = {}
        self._forgotten: list[ProcessSpec] = []

    def __getitem__(self, name: str) -> WaitingProcess:
        return self._entries[name]

    @property
    def waiting(self) -> list[WaitingProcess]:
        return [one for one in self._entries.values() if one.phase is StartPhase.WAITING]

    # ---- events

    def add(self, spec: ProcessSpec) -> list[Action]:
        """A process that may be started from now on."""
        return self._join(WaitingProcess(spec, rule_for(self._rules, spec)))

    def adopt(self, spec: ProcessSpec) -> list[Action]:
        """The process of this name has this spec now; new facts count from its next start."""
        entry = self._entries.pop(spec.name)
        self._disconnect(entry)
        entry.describe(spec, rule_for(self._rules, spec))
        return self._join(entry)

    def follow(self, rules: Sequence[StartRule], now: float) -> list[Action]:
        """Other rules hold from now on; what is ready, or was let pass, stays so."""
        self._rules = rules
        entries = list(self._entries.values())
        self._entries.clear()
        for entry in entries:  # all of them first: a mixture of rules may be a circle
            entry.describe(entry.spec, rule_for(rules, entry.spec))
        actions = [action for entry in entries for action in self._join(entry)]
        running = [entry for entry in entries if entry.is_running]
        return actions + [action for entry in running for action in self._look(entry, now)]

    def forget(self, name: str) -> None:
        """The launch file does not have it any more: nothing waits for it."""
        entry = self._entries.pop(name)
        self._disconnect(entry)
        self._forgotten.append(entry.spec)

    def _disconnect(self, entry: WaitingProcess) -> None:
        for other in self._entries.values():
            for others in other.needs.values():
                others[:] = [one for one in others if one is not entry]

    def _join(self, new: WaitingProcess) -> list[Action]:
        for other in self._entries.values():
            _connect(other, new)
            _connect(new, other)
        self._entries[new.name] = new
        chain = self._circle_with(new) if new.needs else []
        if not chain:
            return []
        new.needs.clear()
        new.rule = replace(new.rule, after=None)
        return [Circle(new.name, tuple(chain))]

    def _circle_with(self, new: WaitingProcess) -> list[str]:
        reached: dict[str, list[str]] = {}
        left = [new]
        while left:
            one = left.pop()
            if one.name not in reached:
                others = _needed(one)
                reached[one.name] = [other.name for other in others]
                left += others
        return circle(reached)

    def admit(self, name: str, now: float) -> bool:
        """Whether it may start at once; else it waits until a `check` releases it."""
        entry = self._entries[name]
        if entry.phase is StartPhase.PASSED or not entry.needs:
            self._pass(entry, now)
            return True
        entry.phase, entry.admitted_s = StartPhase.WAITING, now
        return False

    def withdraw(self, name: str) -> bool:
        """It shall not start any more; False if it was not waiting."""
        entry = self._entries.get(name)
        if entry is None or entry.phase is not StartPhase.WAITING:
            return False
        entry.phase, entry.state = StartPhase.NEW, "it was stopped"
        return True

    def skip(self, name: str, now: float) -> bool:
        """A user starts it: it does not wait any more; False if it was not waiting."""
        entry = self._entries[name]
        is_waiting = entry.phase is StartPhase.WAITING
        self._pass(entry, now)
        return is_waiting

    def _pass(self, entry: WaitingProcess, now: float) -> None:
        entry.phase, entry.passed_s = StartPhase.PASSED, now
        entry.state = "it is being started"

    def started(self, name: str, now: float) -> list[Action]:
        entry = self._entries[name]
        entry.begin(now)
        return self._look(entry, now)

    def fact(self, name: str, index: int, now: float, *, holds: bool, text: str) -> list[Action]:
        """A fact of `ready_when` holds, or `text` is what is seen instead."""
        entry = self._entries[name]
        if not entry.is_running or entry.ready_s is not None:
            return []
        entry.note(index, holds=holds, text=text)
        return self._look(entry, now)

    def ended(
        self, name: str, now: float, returncode: int | None, text: str, *, asked: bool, final: bool
    ) -> list[Action]:
        """It has ended (None: could not be started). `final`: by itself, and is not restarted."""
        entry = self._entries[name]
        actions: list[Action] = []
        if entry.is_running:
            entry.note_exit(returncode)
            actions = self._look(entry, now)
        was_ready = entry.ready_s is not None
        entry.is_finished = was_ready and returncode == 0 and not asked
        entry.is_running, entry.ready_s = False, None
        entry.state = "it was stopped" if asked else f"it has ended ({text})"
        entry.gone = f"it has ended ({text})" if final and not entry.is_finished else ""
        return actions

    def _look(self, entry: WaitingProcess, now: float) -> list[Action]:
        """Whether it is ready now."""
        if entry.ready_s is not None or entry.lacks:
            return []
        entry.ready_s = now
        actions: list[Action] = (
            [ReportReady(entry.name, now - entry.started_s)] if entry.facts else []
        )
        if entry.lives > 1:
            actions += self._restarts_with(entry)
        return actions

    def _restarts_with(self, entry: WaitingProcess) -> Iterator[Action]:
        for other in self._entries.values():
            names = other.rule.restart_with or ()
            if other is entry or not other.is_running or other.started_s > entry.started_s:
                continue  # one that was started later has met only the present life
            if any(matches(name, entry.spec) for name in names):
                yield RestartWith(other.name, entry.name)

    # ---- waiting

    def check(self, now: float) -> list[Action]:
        """Those that need not wait any more, or have waited for too long."""
        actions: list[Action] = []
        for entry in self.waiting:
            lacking = self._lacking(entry)
            waited_s = now - entry.admitted_s
            if not lacking:
                self._pass(entry, now)
                actions.append(ReleaseStart(entry.name, waited_s))
                continue
            gone = next(
                (one for one in lacking if isinstance(one, WaitingProcess) and one.gone), None
            )
            deadline = self._deadline_of(entry)
            if gone is None and (deadline is None or now < deadline):
                continue
            assert entry.rule.after is not None
            text = self._reason(lacking, gone)
            consequence = entry.rule.after.on_timeout
            self._pass(entry, now)
            actions.append(Expire(entry.name, consequence, text, waited_s))
        return actions

    @property
    def deadline(self) -> float | None:
        found = (self._deadline_of(entry) for entry in self.waiting)
        return min((one for one in found if one is not None), default=None)

    def _deadline_of(self, entry: WaitingProcess) -> float | None:
        """The time limit begins when none of those that it waits for waits itself."""
        others = _needed(entry)
        if any(other.phase is StartPhase.WAITING for other in others) or entry.rule.after is None:
            return None
        since_s = max([entry.admitted_s, *(other.passed_s for other in others)])
        return since_s + entry.rule.after.timeout_s

    def _lacking(self, entry: WaitingProcess) -> list[WaitingProcess | str]:
        """The processes that are not ready, and the names that no process has."""
        found: dict[str, WaitingProcess | str] = {}
        for name, others in entry.needs.items():
            if not others and not self._is_no_matter(name, entry):
                found[name] = name
            found.update((one.name, one) for one in others if not one.is_satisfied)
        return list(found.values())

    def _is_no_matter(self, name: str, entry: WaitingProcess) -> bool:
        """Whether it means only the process itself, or one that is gone, or kept away."""
        none = (entry.spec, *self._forgotten, *self._switched_off())
        return any(matches(name, spec) for spec in none)

    def _reason(
        self, lacking: Sequence[WaitingProcess | str], first: WaitingProcess | None = None
    ) -> str:
        """`dispatcher: no publisher on /fleet/tasks, and for monitor`."""
        head = lacking[0] if first is None else first
        others = [_shown(one) for one in lacking if one is not head]
        if isinstance(head, str):
            text = f"{head}: it has not been started"
        elif head.phase is StartPhase.WAITING and (its := self._lacking(head)):
            text = f"{_shown(head)}, which waits for {_shown(its[0])}"
        else:
            text = f"{_shown(head)}: {head.lack()}"
        if len(others) > 1:
            return f"{text}, and for {len(others)} more"
        return f"{text}, and for {others[0]}" if others else text

    # ---- for users

    def needed(self, name: str) -> list[str]:
        """The processes that it waits for, or has waited for."""
        return list(dict.fromkeys(one.name for one in _needed(self._entries[name])))

    def reason(self, name: str) -> str:
        """What it waits for, or lacks to be ready; empty if neither."""
        entry = self._entries[name]
        if entry.phase is StartPhase.WAITING:
            lacking = self._lacking(entry)
            return self._reason(lacking) if lacking else ""
        return entry.lack() if entry.is_running and entry.ready_s is None else ""


def _shown(one: WaitingProcess | str) -> str:
    """The name of its node, where the launch file gives one: several may have one executable."""
    if isinstance(one, str):
        return one
    node = None if one.spec.ros is None else one.spec.ros.node_name
    return one.spec.label if node is None else node.rpartition("/")[2]


def _connect(entry: WaitingProcess, other: WaitingProcess) -> None:
    """Note that an entry waits for another, if its names say so."""
    for name, others in entry.needs.items():
        if matches(name, other.spec):
            others.append(other)


def _needed(entry: WaitingProcess) -> list[WaitingProcess]:
    return [other for others in entry.needs.values() for other in others]
