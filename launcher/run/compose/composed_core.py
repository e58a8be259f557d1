"""Between the launch file, which has an action for each node, and the engine, which has a process.

Effects about a member of a group become effects about the group, events of the group become events
of its members. Both sides stay as they are.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Mapping, Sequence

from launcher.base.errors import LauncherError
from launcher.base.model import events
from launcher.base.model.record import Record
from launcher.base.model.spec import ProcessSpec

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.core_driver import ReloadableCore

_FIRST_GROUP = 1 << 29  # ids of processes of the launch file are smaller


class Composition(Record):
    """Which processes become one: (process of the group, ids of its members in order).

    `remarks` are sentences about processes that are not composed.
    """

    groups: tuple[tuple[ProcessSpec, tuple[int, ...]], ...] = ()
    remarks: tuple[str, ...] = ()


class _Group:
    """`codes` are those of members that have ended, `reported` those whose end the core has got."""

    def __init__(self, spec: ProcessSpec, members: Sequence[int]) -> None:
        self.spec = spec
        self.members = members
        self.codes: dict[int, int] = {}
        self.reported: set[int] = set()


class ComposedCore:
    """The core of a run with groups. `late(spec)`: a sentence about what is started later."""

    def __init__(
        self,
        core: ReloadableCore,
        composition: Composition,
        late: Callable[[ProcessSpec], str | None],
    ) -> None:
        self._core = core
        self._remarks = composition.remarks
        self._late = late
        self._groups: dict[int, _Group] = {}
        self._place: dict[int, tuple[int, int]] = {}  # member -> (its group, index in it)
        for number, (spec, members) in enumerate(composition.groups, _FIRST_GROUP):
            self._groups[number] = _Group(spec, members)
            self._place.update((one, (number, index)) for index, one in enumerate(members))

    # ---- effects

    def start(self) -> Sequence[events.Effect]:
        remarks = [_remark(text) for text in self._remarks]
        started = [one for effect in self._core.start() for one in self._translated(effect)]
        return [*remarks, *started]

    def _translated(self, effect: events.Effect) -> Iterable[events.Effect]:
        number, index = self._place.get(getattr(effect, "process_id", -1), (-1, 0))
        if number < 0:
            return [effect]
        group = self._groups[number]
        match effect:
            case events.StartProcess():  # where the first of its members would start
                return [events.StartProcess(number, group.spec)] if index == 0 else []
            case events.SignalProcess(signum=signum):
                return [_request(number, index, signum)]
            case events.StopProcess():
                return [_request(number, index, signal.SIGINT)]
            case events.WriteStdin():
                name = group.spec.members[index].name
                return [_remark(f"{name} is composed, and has no standard input", "WARNING")]
        return [effect]

    # ---- events

    def handle(self, event: events.Event) -> Sequence[events.Effect]:
        effects: list[events.Effect] = []
        for one in self._split(event):
            for effect in self._core.handle(one):
                text = self._late(effect.spec) if isinstance(effect, events.StartProcess) else None
                effects += [_remark(text)] if text else []
                effects += self._translated(effect)
        return effects

    def _split(self, event: events.Event) -> list[events.Event]:
        """The events for the core: of each member, in place of the group."""
        group = self._groups.get(getattr(event, "process_id", -1))
        if group is None:
            return [event]
        match event:
            case events.ProcessStarted(pid=pid):
                group.codes.clear()
                group.reported.clear()
                return [events.ProcessStarted(one, pid) for one in group.members]
            case events.MemberExited():
                return self._member_exited(group, event)
            case events.ProcessExited(pid=pid, returncode=code, will_restart=will_restart):
                left = [one for one in group.members if one not in group.reported]
                codes = {one: group.codes.get(one, code) for one in left}
                return [
                    events.ProcessExited(one, pid, codes[one], will_restart=will_restart)
                    for one in left
                ]
            case events.SpawnFailed(errno=number, reason=reason, will_restart=will_restart):
                return [
                    events.SpawnFailed(one, number, reason, will_restart) for one in group.members
                ]
        return []

    def _member_exited(self, group: _Group, event: events.MemberExited) -> list[events.Event]:
        """One that ends with the group is reported with the end of the group."""
        member, code = group.members[event.index], event.returncode
        group.codes[member] = code
        if code or event.with_process or group.spec.members[event.index].is_essential:
            return []
        group.reported.add(member)
        return [events.ProcessExited(member, event.pid, code)]

    def watches_output(self, process_id: int) -> bool:
        """Nodes whose output a handler reads are not composed."""
        return process_id not in self._groups and self._core.watches_output(process_id)

    # ---- the rest is that of the core

    @property
    def has_failed(self) -> bool:
        return self._core.has_failed

    def plan(self) -> Mapping[str, Any]:
        return self._core.plan()

    def plan_lines(self) -> Sequence[str]:
        return self._core.plan_lines()

    def intentions(self) -> Sequence[str]:
        return self._core.intentions()

    def stay_while(self, condition: Callable[[], bool]) -> None:
        self._core.stay_while(condition)

    def read_options(self) -> Any:
        self.launch_files()

    def evaluate_again(self, *arguments: object) -> Any:
        self.launch_files()

    def launch_files(self) -> list[str]:
        hint = "end the run, and start it again"
        raise LauncherError("a run with composed nodes cannot be reloaded", hint=hint)

    def is_steered(self, spec: ProcessSpec) -> bool:
        return False  # its restart cannot repeat what the launch file has asked


def _request(number: int, index: int, signum: int) -> events.Effect:
    """For the process of the group, which reads this (`launcher.ros.composed.member_group`)."""
    return events.WriteStdin(number, b"%d %d\n" % (index, signum))


def _remark(text: str, level: str = "INFO") -> events.Effect:
    return events.LogMessage(logger="launch", level=level, text=text)
