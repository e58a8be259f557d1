"""The injections of a run, and the verb `inject`."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Collection, Iterable, Sequence

from launcher.base.document.fields import FieldError
from launcher.base.model.injection_events import InjectionBegan, InjectionEnded
from launcher.base.option import load
from launcher.base.run_verb import BadCallError
from launcher.run.part import Part
from launcher.run.requests.process_selection import refuse_part
from launcher.smoke.inject import processors
from launcher.smoke.inject.effects import Effect
from launcher.smoke.inject.grammar import (
    EXAMPLE,
    KINDS,
    MACHINE,
    Injection,
    parsed,
    refuse_machine,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from launcher.posix.reactor import Timer
    from launcher.run.part import VerbRequest
    from launcher.run.processes.machine_events import ReportExit
    from launcher.run.processes.process import Process
    from launcher.run.run import Run

Answered = Callable[["str | None"], None]
EFFECTS = {
    "pause": "launcher.smoke.inject.effects:PauseEffect",
    "slow": "launcher.smoke.inject.effects:SlowEffect",
    "kill": "launcher.smoke.inject.effects:KillEffect",
    "drop": "launcher.smoke.inject.topic_effect:TopicEffect",
    "delay": "launcher.smoke.inject.topic_effect:TopicEffect",
    **dict.fromkeys(("cpu", "memory", "disk"), "launcher.smoke.inject.effects:StressEffect"),
}
# Of these kinds, one process has one at a time: they would undo each other.
_EXCLUSIVE = (("pause", "slow"), ("drop", "delay"))
_ON_OTHER_HOSTS = ("pause", "kill")
LOOK_S = 0.1
TIME_IS_OVER = "its time is over"


class ActiveInjection:
    """One that has begun, or is just beginning: then `began_s` is None."""

    def __init__(self, injection: Injection, process: Process | None, effect: Effect) -> None:
        self.injection = injection
        self.process = process
        self.effect = effect
        self.began_s: float | None = None
        self.until_s: float | None = None
        self.began_wall_s = time.time()
        self.timer: Timer | None = None
        self.why = ""  # it ends
        self.waiting: list[Callable[[], None]] = []  # for its end

    @property
    def is_ending(self) -> bool:
        return bool(self.why)

    @property
    def name(self) -> str:
        return _name(self.process)

    def document(self, now: float) -> dict[str, Any]:
        """As in docs/reference/json.md; `now` is the time of the reactor."""
        for_s, left_s = self.injection.for_s, 0.0
        if self.until_s is not None and not self.is_ending:
            left_s = max(0.0, round(self.until_s - now, 3))
        return {
            "name": self.name,
            "injection": self.injection.text,
            "began_wall_s": self.began_wall_s,
            "for_s": for_s,
            "left_s": left_s,
            "problem": None,
        }


class Injections(Part):
    """Those that are active; each ends with its time, its process, or the run."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._active: list[ActiveInjection] = []
        self._looks = False

    def of(self, processes: Collection[Process | None]) -> list[ActiveInjection]:
        """Those into these processes, or the machine (None)."""
        return [one for one in self._active if one.process in processes]

    @property
    def active(self) -> list[ActiveInjection]:
        return list(self._active)

    # ---- begin and end

    def begin_one(
        self, injection: Injection, process: Process | None, done: Answered
    ) -> ActiveInjection:
        """Inject it, and call `done` with None when it is in force, or with what has failed.

        BadCallError if it is not possible now.
        """
        self._refuse(injection, process)
        effect: Effect = load(EFFECTS[injection.kind])(self.run, injection, process)
        one = ActiveInjection(injection, process, effect)
        self._active.append(one)
        if not self._looks:
            self._looks = True
            self.run.reactor.call_later(LOOK_S, self._look)
        effect.on_lost = functools.partial(self._lost, one)
        effect.begin(functools.partial(self._acts, one), functools.partial(self._begun, one, done))
        return one

    def _refuse(self, injection: Injection, process: Process | None) -> None:
        kind = injection.kind
        if self.run.shutdown.has_begun:
            raise BadCallError("stopping", "the run is being stopped")
        if kind == "disk" and self.run.log_dir is None:
            raise BadCallError("wrong-state", "this run has no log folder, whose disk is filled")
        if kind == "cpu":
            self._refuse_cores(injection)
        if process is None:
            return
        if process.child is None:
            state = process.machine.state.value
            raise BadCallError("wrong-state", f"{process.name} is not running ({state})")
        if process.host is not None and kind not in _ON_OTHER_HOSTS:
            where = f"{process.name} runs on {process.host_name}"
            raise BadCallError("wrong-state", f"{where}: {kind} works on this machine only")
        for kinds in _EXCLUSIVE:
            for one in self.of([process]) if kind in kinds else ():
                if one.injection.kind in kinds:
                    text = f"{process.name}: {one.injection.text} is active"
                    hint = f"inject {process.name} --end"
                    raise BadCallError("wrong-state", text, hint)

    def _refuse_cores(self, injection: Injection) -> None:
        """Injections into several processes use the same processors."""
        own = processors.usable()
        cores = [one.injection.value("cores") or own for one in self._active if _is_cpu(one)]
        total = sum(cores) + (injection.value("cores") or own)
        if problem := processors.excess(total, own):
            with_others = f"with the {sum(cores)} of others, " if cores else ""
            raise BadCallError("wrong-state", f"cpu: {with_others}{problem}")

    def _acts(self, one: ActiveInjection) -> None:
        """It can be seen from now on."""
        one.began_s, one.began_wall_s = self.run.reactor.now(), time.time()
        event = InjectionBegan(one.injection.text, one.injection.for_s)
        self.run.log.log("INFO", _logger(one), event.text)
        self.run.log.note(event, one.process)
        if one.effect.counts_beginning:
            self._limit(one)

    def _begun(self, one: ActiveInjection, done: Answered, problem: str | None) -> None:
        if problem is not None:
            self._finish(one, one.why or f"it failed: {problem}")
        elif one.injection.for_s is None:
            self._active.remove(one)
        elif not one.is_ending and one.timer is None:
            self._limit(one)
        done(problem)

    def _limit(self, one: ActiveInjection) -> None:
        """Let its time begin now, if it lasts."""
        if one.injection.for_s is not None:
            end = functools.partial(self.end, one, TIME_IS_OVER)
            one.until_s = self.run.reactor.now() + one.injection.for_s
            one.timer = self.run.reactor.call_later(one.injection.for_s, end)

    def _lost(self, one: ActiveInjection, reason: str) -> None:
        self._finish(one, f"it failed: {reason}")

    def end(self, one: ActiveInjection, why: str, done: Callable[[], None] = lambda: None) -> None:
        """Undo it, and call `done` when everything is as before."""
        one.waiting.append(done)
        if not one.is_ending:
            one.why = why
            if one.timer is not None:
                one.timer.cancel()
            one.effect.end(functools.partial(self._finish, one, why))

    def _finish(self, one: ActiveInjection, why: str) -> None:
        """Everything is as before."""
        if one in self._active:
            self._active.remove(one)
            if one.timer is not None:
                one.timer.cancel()
            if one.began_s is not None:
                lasted_s = round(self.run.reactor.now() - one.began_s, 3)
                event = InjectionEnded(one.injection.text, lasted_s, why)
                self.run.log.log("INFO", _logger(one), event.text)
                self.run.log.note(event, one.process)
        waiting, one.waiting = one.waiting, []
        for done in waiting:
            done()

    # ---- hooks

    def ended(self, process: Process, end: ReportExit) -> None:
        for one in self.of([process]):
            if not one.effect.survives and one.injection.for_s is not None:
                self.end(one, "the process has ended")

    def adopted(self, process: Process) -> None:
        for one in self.of([process]):
            if one.effect.survives:
                self.end(one, "the launch file was reloaded")

    def _look(self) -> None:
        """Requests of users and signals from elsewhere are no change of a state."""
        self._looks = bool(self._active)
        if self._looks:
            self.changed()
            self.run.reactor.call_later(LOOK_S, self._look)

    def changed(self) -> None:
        for one in self.active if self._active else ():
            why = "" if one.is_ending or one.began_s is None else one.effect.broken_by()
            if why:
                self.end(one, why)

    def stopping(self) -> None:
        for one in self.active:
            self.end(one, "the run is being stopped")

    def end_helpers(self) -> None:
        for one in self.active:
            one.effect.close()
            self._finish(one, one.why or "the run has ended")

    def row(self, process: Process) -> Mapping[str, object]:
        kinds = {one.injection.kind: one.injection.text for one in self.of([process])}
        if not kinds:
            return {}
        row: dict[str, object] = {"injected": list(kinds.values())}
        # One that is slow is suspended for most of the time, and runs all the same.
        return {**row, "paused": False} if "slow" in kinds else row


def _name(process: Process | None) -> str:
    return MACHINE if process is None else process.name


def _is_cpu(one: ActiveInjection) -> bool:
    return one.injection.kind == "cpu"


def _logger(one: ActiveInjection) -> str:
    return "launch" if one.process is None else one.process.name


# ---- the verb


def serve(request: VerbRequest) -> None:
    """Begin, end, or list injections, and answer when that is done; BadCallError."""
    injections, options = request.run.parts.need(Injections), request.call.options
    names, text = request.call.names, options.get("what")
    if options.get("end"):
        if text or "for_s" in options:
            raise BadCallError("bad-request", "--end takes a name only")
        _end(request, injections)
    elif text is None:
        if names and names[0] in KINDS:
            hint = f"as in 'inject {EXAMPLE}'"
            raise BadCallError("bad-request", f"{names[0]}: a name is missing in front", hint)
        if "for_s" in options:
            raise BadCallError("bad-request", "it is not said what to inject")
        _list(request, injections)
    else:
        _begin(request, injections, text)


def _targets(request: VerbRequest) -> Sequence[Process | None]:
    """The processes that the call names; [None]: the machine."""
    names = request.call.names
    is_process = any(MACHINE in (one.name, one.spec.label) for one in request.run.processes)
    if names == (MACHINE,) and not is_process:
        return [None]
    return request.chosen()


def _begin(request: VerbRequest, injections: Injections, text: str) -> None:
    names = request.call.names
    if not names:
        raise BadCallError("bad-request", "the name of a process is missing", f"or '{MACHINE}'")
    try:
        injection = parsed(text, request.call.options.get("for_s"))
        targets = _targets(request)
        if None in targets:
            refuse_machine(injection)
    except FieldError as error:
        raise BadCallError("bad-option", str(error), error.hint) from None
    for known in filter(None, targets):
        refuse_part("inject", names, known.spec)
    answers = _InjectionAnswers(request, len(targets))
    for process in targets:
        try:
            answers.begin(injections, injection, process)
        except BadCallError as error:
            if len(targets) == 1:
                raise
            answers.add({"name": _name(process), "injection": text}, error.message)


class _InjectionAnswers:
    """The answer to one request, when all of its processes have theirs."""

    def __init__(self, request: VerbRequest, count: int) -> None:
        self._request = request
        self._missing = count
        self._documents: list[dict[str, Any]] = []

    def begin(self, injections: Injections, injection: Injection, process: Process | None) -> None:
        begun: list[ActiveInjection] = []

        def done(problem: str | None) -> None:
            now = self._request.run.reactor.now()
            one = begun[0] if begun else None
            known = one.document(now) if one else {}
            self.add({"name": _name(process), "injection": injection.text, **known}, problem)

        def soon(problem: str | None) -> None:  # it may be in force before it is returned
            self._request.run.reactor.call_later(0, functools.partial(done, problem))

        begun.append(injections.begin_one(injection, process, soon))

    def add(self, known: dict[str, Any], problem: str | None) -> None:
        empty = {"began_wall_s": None, "for_s": None, "left_s": 0.0}
        self._documents.append({**empty, **known, "problem": problem})
        self._missing -= 1
        if self._missing:
            return
        problems = [one["problem"] for one in self._documents]
        if all(problems):
            texts = (f"{one['name']}: {one['problem']}" for one in self._documents)
            self._request.exchange.fail(BadCallError("wrong-state", "; ".join(texts)))
        else:
            reply(self._request, self._documents)


def _chosen(request: VerbRequest, injections: Injections) -> list[ActiveInjection]:
    return injections.of(_targets(request)) if request.call.names else injections.active


def _list(request: VerbRequest, injections: Injections) -> None:
    now = request.run.reactor.now()
    reply(request, [one.document(now) for one in _chosen(request, injections)])


def _end(request: VerbRequest, injections: Injections) -> None:
    chosen = _chosen(request, injections)
    if not chosen:
        into = f" into {request.call.names[0]}" if request.call.names else ""
        raise BadCallError("wrong-state", f"nothing is injected{into}")
    missing = len(chosen)

    def done() -> None:
        nonlocal missing
        missing -= 1
        if not missing:
            now = request.run.reactor.now()
            reply(request, [one.document(now) for one in chosen], ends=True)

    for one in chosen:
        injections.end(one, "requested", done)


def reply(request: VerbRequest, documents: list[dict[str, Any]], *, ends: bool = False) -> None:
    lines = list(_lines(documents, ends=ends)) or ["nothing is injected"]
    request.exchange.reply({"injections": documents}, lines)


def _lines(documents: Iterable[dict[str, Any]], *, ends: bool) -> Iterable[str]:
    for one in documents:
        text = f"{one['name']}: {one['injection']}"
        if one["problem"]:
            yield f"{text}: {one['problem']}"
        elif ends:
            yield f"{text} is over"
        elif one["for_s"] is None:
            yield text
        else:
            yield f"{text} for {one['for_s']:g} s, {one['left_s']:.1f} s left"
