"""Brings a new evaluation of the launch file to the moment at which a run is.

The new interpreter gets the events of the processes that it has in common with the run: they have
started, and some have ended. Timers whose time has passed since the start of the run have fired.
What follows from that is compared with the run in the same way. Nothing is carried out: the result
is a `Reload`.
"""

from __future__ import annotations

import errno
import functools
import heapq
import itertools
import os
from collections.abc import Callable, Collection, Sequence

from launcher.base.model import events as model
from launcher.base.model.lifecycle_transitions import transition_steps
from launcher.base.model.record import replace
from launcher.base.model.reload_changes import Kept, Known, Reload
from launcher.base.model.ros_arguments import full_node_name
from launcher.base.model.spec import ProcessSpec
from launcher.base.model.spec_diff import comparable, differences, match, needs_restart
from launcher.language.interpreter.interpreter import Interpreter

MAX_EVENTS = 10_000  # a launch file may set timers for ever

Requests = model.LoadRequest | model.StateRequest


class Replay:
    """One evaluation.

    `done` are the requests to ROS nodes that the run has made, `said` its messages. `adapt` applies
    the options of the run to a spec.
    """

    def __init__(
        self,
        interpreter: Interpreter,
        known: Sequence[Known],
        *,
        done: Collection[Requests],
        said: Collection[model.LogMessage],
        adapt: Callable[[ProcessSpec], ProcessSpec],
        numbered: int,
    ) -> None:
        self._interpreter = interpreter
        self._left = list(known)
        self._known = {one.process_id: one for one in known}
        self._done = done
        self._said = said
        self._adapt = adapt
        self._numbered = numbered
        self._kept: list[Kept] = []
        self._effects: list[model.Effect] = []
        self._after: dict[int, list[model.Effect]] = {}
        self._timers: dict[int, tuple[float, model.CallLater]] = {}
        self._queue: list[tuple[float, int, model.Event]] = []
        self._sequence = itertools.count()
        self._elapsed_s = 0.0
        self._loads: list[model.LoadComponent] = []
        self.repeated: list[model.Effect] = []  # what the run has done already
        # Containers that are restarted, and whose start the interpreter has got.
        self.started: set[int] = set()

    def run(self, elapsed_s: float) -> Reload:
        """Evaluate up to this time since the start of the run; LaunchFileError."""
        host, self._elapsed_s = self._interpreter.host, elapsed_s
        host.shutdown_filter = lambda event: False  # the run goes on
        self._interpreter.stay_while(lambda: True)
        self._take(self._interpreter.start(), 0.0)
        for _ in range(MAX_EVENTS):
            if not self._queue or self._queue[0][0] > elapsed_s:
                break
            when_s, _, event = heapq.heappop(self._queue)
            self._handle(event, when_s)
        host.shutdown_filter = lambda event: True
        self._interpreter.stay_while(lambda: False)
        host.numbered = self._numbered
        self._restart_containers()
        for timer_id, (due_s, effect) in self._timers.items():
            if timer_id in host.timers:
                self._effects.append(replace(effect, delay_s=max(0.0, due_s - elapsed_s)))
        return Reload(
            kept=tuple(self._kept),
            gone=tuple(one.process_id for one in self._left),
            effects=tuple(self._effects),
            after=tuple((number, tuple(effects)) for number, effects in self._after.items()),
        )

    def _handle(self, event: model.Event, when_s: float) -> None:
        if isinstance(event, model.TimerFired):
            self._timers.pop(event.timer_id, None)
        effects = self._interpreter.handle(event)
        if self._interpreter.failure is not None:
            raise self._interpreter.failure
        self._take(effects, when_s)

    def _at(self, when_s: float, event: model.Event) -> None:
        heapq.heappush(self._queue, (when_s, next(self._sequence), event))

    def _take(self, effects: Sequence[model.Effect], now_s: float) -> None:
        self._match([one for one in effects if isinstance(one, model.StartProcess)], now_s)
        for effect in effects:
            match effect:
                case model.CallLater(timer_id=timer_id, delay_s=delay_s):
                    self._timers[timer_id] = (now_s + delay_s, effect)
                    self._at(now_s + delay_s, model.TimerFired(timer_id))
                case model.LoadComponent(request_id=request_id, request=load):
                    self._load(effect, load, request_id, now_s)
                case model.ChangeState(request_id=request_id, request=change):
                    self._change_state(effect, change, request_id, now_s)
                case model.WatchLifecycle() | model.UseSimTime():
                    self._effects.append(effect)
                case model.LogMessage():
                    (self.repeated if effect in self._said else self._effects).append(effect)
                # Signals, stops and input: the processes have got them.

    # ---- processes

    def _match(self, starts: Sequence[model.StartProcess], now_s: float) -> None:
        found = match([one.spec for one in self._left], [comparable(one.spec) for one in starts])
        old = {index: self._left[place] for index, place in found.items()}
        for index, effect in enumerate(starts):
            if index in old:
                self._left.remove(old[index])
                self._keep(effect, old[index], now_s)
            else:
                self._numbered += 1
                name = f"{effect.spec.label}-{self._numbered}"
                self._interpreter.host.rename(effect.process_id, name)
                self._effects.append(replace(effect, spec=replace(effect.spec, name=name)))

    def _keep(self, effect: model.StartProcess, known: Known, now_s: float) -> None:
        self._interpreter.host.rename(effect.process_id, known.name, known.process_id)
        planned = replace(effect.spec, name=known.name)
        spec = self._adapt(planned)
        changes = differences(known.spec, comparable(spec))
        if known.is_edited:
            changes.append("files")
        postponed: list[str] = []
        if known.is_debugged and needs_restart(changes):
            spec, changes, postponed = known.spec.spec, [], changes
        kept = Kept(known.process_id, spec, planned, tuple(changes), tuple(postponed))
        self._kept.append(kept)
        if known.is_stopped or not needs_restart(changes):  # else the run reports what happens
            self._report(known, now_s)

    def _report(self, known: Known, now_s: float) -> None:
        number = known.process_id
        started_s = max(now_s, self._elapsed_s - known.started_ago_s)
        ended_s = max(now_s, self._elapsed_s - known.ended_ago_s)
        if known.has_started:
            self._at(started_s, model.ProcessStarted(number, known.pid or 0))
        if known.has_ended and known.returncode is not None:
            self._at(ended_s, model.ProcessExited(number, 0, known.returncode))
        elif known.has_ended:
            reason = os.strerror(errno.ECANCELED)
            self._at(ended_s, model.SpawnFailed(number, errno.ECANCELED, reason))

    # ---- requests to nodes

    def _restarting(self, node: str) -> int | None:
        """The process of this node, if it is restarted."""
        node = _absolute(node)
        for one in self._kept:
            if needs_restart(one.changes) and full_node_name(one.spec.argv) == node:
                return one.process_id
        return None

    def _is_done(self, request: Requests, node: str) -> bool:
        if request not in self._done or self._restarting(node) is not None:
            return False
        return any(full_node_name(one.spec.argv) == _absolute(node) for one in self._kept)

    def _owner(self, node: str) -> str:
        """The container of a component; other nodes are processes themselves."""
        loads = [effect.request for effect in self._loads]
        return next((one.container for one in loads if one.full_name == node), node)

    def _send(self, effect: model.Effect, node: str) -> None:
        process_id = self._restarting(node)
        if process_id is None:
            self._effects.append(effect)
        else:
            self._after.setdefault(process_id, []).append(effect)

    def _load(
        self, effect: model.LoadComponent, load: model.LoadRequest, request_id: int, now_s: float
    ) -> None:
        self._loads.append(effect)
        if not self._is_done(load, load.container):
            self._send(effect, load.container)
            return
        self.repeated.append(effect)
        self._at(now_s, model.ComponentLoaded(request_id, full_node_name=load.full_name))

    def _change_state(
        self, effect: model.ChangeState, change: model.StateRequest, request_id: int, now_s: float
    ) -> None:
        owner = self._owner(change.node)
        if not self._is_done(change, owner):
            self._send(effect, owner)
            return
        self.repeated.append(effect)
        self._at(now_s, model.StateChanged(request_id))
        for label, start, goal in transition_steps(change.transition_id):
            self._at(now_s, model.TransitionSeen(change.node, label, start, goal))

    # ---- containers whose nodes have changed

    def _restart_containers(self) -> None:
        """Restart containers that run on although their nodes are not the same any more.

        That is known only now, when the interpreter has taken their nodes for loaded: they are
        loaded again, all of them, when the container runs.
        """
        stale = self._stale_containers()
        for index, kept in enumerate(self._kept):
            if full_node_name(kept.spec.argv) not in stale:
                continue
            known = self._known[kept.process_id]
            if known.is_debugged:
                postponed = (*kept.postponed, "components")
                self._kept[index] = replace(kept, spec=known.spec.spec, postponed=postponed)
                continue
            self._kept[index] = replace(kept, changes=(*kept.changes, "components"))
            if known.has_started and not known.is_stopped:
                self.started.add(kept.process_id)
            self._repeat_after(kept.process_id, str(full_node_name(kept.spec.argv)))

    def _stale_containers(self) -> set[str]:
        """Their full names."""
        before = [one for one in self._done if isinstance(one, model.LoadRequest)]
        now = [effect.request for effect in self._loads]
        changed = [one for one in before if one not in now]
        changed += [one for one in now if one not in before]
        running = {
            full_node_name(one.spec.argv) for one in self._kept if not needs_restart(one.changes)
        }
        return {_absolute(one.container) for one in changed} & {name for name in running if name}

    def _repeat_after(self, process_id: int, node: str) -> None:
        """Send the requests to this node when its process has been restarted."""
        again = [
            one
            for one in (*self.repeated, *self._effects)
            if isinstance(one, (model.LoadComponent, model.ChangeState))
            and self._process_of(one) == node
        ]
        self.repeated = [one for one in self.repeated if one not in again]
        self._effects = [one for one in self._effects if one not in again]
        again.sort(key=lambda one: one.request_id)
        self._after.setdefault(process_id, []).extend(again)
        waiting = self._interpreter.host.waiting
        for one in again:
            if isinstance(one, model.LoadComponent):
                waiting.setdefault(one.request_id, functools.partial(self._loaded, one.request))

    def _loaded(self, load: model.LoadRequest, answer: model.ComponentLoaded) -> None:
        """The answer about a node that the interpreter takes for loaded."""
        if answer.error is not None:
            text = (
                f"Failed to load node '{load.name}' of type '{load.plugin}' again: {answer.error}"
            )
            self._interpreter.host.log("launch", "ERROR", text)

    def _process_of(self, effect: model.LoadComponent | model.ChangeState) -> str:
        """The node of the process that a request is for."""
        if isinstance(effect, model.LoadComponent):
            return _absolute(effect.request.container)
        return _absolute(self._owner(effect.request.node))


def _absolute(node: str) -> str:
    return f"/{node.lstrip('/')}"
