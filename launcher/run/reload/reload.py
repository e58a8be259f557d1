"""Carries out what a new evaluation of the launch file means for the processes of the run."""

from __future__ import annotations

import enum
import errno
import functools
import time
from collections.abc import Callable, Collection, Mapping, Sequence

from launcher.base.errors import LauncherError, LaunchFileError
from launcher.base.model.events import ChangeState, Effect, LoadComponent, StartProcess
from launcher.base.model.record import Record, replace
from launcher.base.model.reload_changes import Kept, Known, Reload
from launcher.base.model.run_events import Reloaded
from launcher.base.model.spec_diff import comparable, needs_restart
from launcher.base.model.supervision import setting_changes
from launcher.base.run_verb import BadCallError
from launcher.base.text import count
from launcher.run.part import Part
from launcher.run.part_verbs import DRY_RUN
from launcher.run.processes.machine_events import ProcessState
from launcher.run.processes.process import Process, adapted
from launcher.run.requests.process_control import ProcessControl
from launcher.run.requests.request_queue import ProcessRequest, Purpose
from launcher.run.requests.request_result import Kind, Result
from launcher.run.requests.result_sentences import sentence

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.base.model.run_options import RunOptions
    from launcher.run.core_driver import Evaluation, ReloadableCore
    from launcher.run.part import Exchange, VerbRequest
    from launcher.run.run import Run


# What is about processes that may only be started when those that are gone have ended.
_OF_PROCESSES = (StartProcess, LoadComponent, ChangeState)


class Change(enum.Enum):
    """How a reload affects a process."""

    NEW = "new"
    GONE = "gone"
    CHANGED = "changed"
    SAME = "same"


class ComparedProcess(Record):
    """A process in a comparison of the run with its launch file; `details`: what has changed.

    `result` is what was done; None if nothing was, or in a comparison without consequences. One
    that is left as it is has it in both.
    """

    name: str
    change: Change
    details: tuple[str, ...] = ()
    result: Result | None = None


Done = Callable[[Sequence[ComparedProcess]], None]
ResultDone = Callable[["Result | None"], None]


class _Countdown:
    """Calls `finish` when all that was added is done."""

    def __init__(self, finish: Callable[[], None]) -> None:
        self._finish = finish
        self._left = 0

    def add(self) -> None:
        self._left += 1

    def done(self) -> None:
        self._left -= 1
        if self._left == 0:
            self._finish()

    def of(self, ended: Callable[[Result], None]) -> ResultDone:
        """A callback for one that is added now; with a result it is passed on."""
        self.add()

        def done(result: Result | None) -> None:
            if result is not None:
                ended(result)
            self.done()

        return done


def restart_changed(
    control: ProcessControl, process: Process, done: Callable[[Result], None]
) -> None:
    """Restart it because its files or its description have changed.

    The launch file gets no event of its exit: `on_exit` of an edited node must not end the run.
    """
    control.ask(process, ProcessRequest(Purpose.RESTART, done, is_replacement=True))


def _begun(process: Process) -> Result:
    if process.child is not None:
        return Result(process.name, Kind.STARTED, done=True, pid=process.child.pid)
    if process.machine.state is ProcessState.STARTING:
        return Result(process.name, Kind.QUEUED, done=True)
    outcome = None if process.last_end is None else process.last_end.outcome
    return Result(process.name, Kind.START_FAILED, done=False, exit=outcome)


class Reloader(Part):
    """One reload at a time."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._reactor = run.reactor
        self._core_driver = run.core_driver
        self._log = run.log
        self._processes = run.all_processes
        self.is_busy = False

    @property
    def core(self) -> ReloadableCore:
        """LauncherError if this run has no launch file that can be evaluated again."""
        for part in self.run.parts:
            if part.no_reload:
                raise LauncherError(part.no_reload)
        if self.run.launched.is_script:
            raise LauncherError("a script with a LaunchService cannot be reloaded")
        core: ReloadableCore = self.run.core  # type: ignore[assignment]
        if not hasattr(core, "evaluate_again"):
            raise LauncherError("an attached run cannot be reloaded")
        return core

    def compare(self) -> list[ComparedProcess]:
        """What `reload` would do; LauncherError."""
        evaluation, options = self._evaluate()
        evaluation.discard()
        return self._entries(evaluation.reload, options)

    def reload(self, done: Done, edited: Collection[Process] = ()) -> None:
        """Call `done` when everything is carried out; LauncherError, and nothing was changed.

        The files of those that are `edited` have changed: they are restarted in any case.
        """
        evaluation, options = self._evaluate(edited)
        reload, entries = evaluation.reload, self._entries(evaluation.reload, options)
        self.core.adopt(evaluation)
        self.run.follow(options)
        self._core_driver.forget()
        self._log.note(Reloaded(**_names(entries)))
        self.is_busy = True
        results: dict[str, Result] = {}
        waiting = _Countdown(lambda: self._finish(entries, results, done))

        def ended(result: Result) -> None:
            results[result.process] = result

        waiting.add()
        for one in reload.kept:
            self._keep(one, waiting.of(ended), dict(reload.after).get(one.process_id, ()))
        self._core_driver.carry_out([e for e in reload.effects if not isinstance(e, _OF_PROCESSES)])
        begin = [one for one in reload.effects if isinstance(one, _OF_PROCESSES)]
        stopping = _Countdown(lambda: self._begin(begin, ended, waiting))
        stopping.add()
        for number in reload.gone:
            self._drop(self._processes[number], stopping.of(ended))
        stopping.done()

    def _keep(self, kept: Kept, done: ResultDone, after: Sequence[Effect]) -> None:
        process, spec = self._processes[kept.process_id], kept.spec
        if not needs_restart(kept.changes):
            policies = {"restart": spec.restart, "stop": spec.stop}
            process.adopt(replace(process.spec, place=spec.place, **policies))
            done(None)
            return
        process.adopt(spec)
        for part in self.run.parts:
            part.adopted(process)
        if self.run.driver.waits(process):  # it goes on waiting, as it is now
            self._core_driver.carry_out(after)
            done(Result(process.name, Kind.QUEUED, done=True))
            return
        if process.machine.state in (ProcessState.STOPPED, ProcessState.STOPPING):
            done(None)  # it stays so
            return

        def restarted(result: Result) -> None:
            self._core_driver.carry_out(after)
            done(result)

        restart_changed(self.run.process_control, process, restarted)

    def _drop(self, process: Process, done: ResultDone) -> None:
        process.is_gone = True

        def stopped(result: Result) -> None:
            process.machine.is_held = False
            self._forget(process)
            done(result)

        if process.machine.is_pending:
            self.run.process_control.stop(process, stopped)
        else:
            process.machine.is_held = False
            self._forget(process)
            done(None)

    def _forget(self, process: Process) -> None:
        for part in self.run.parts:
            part.dropped(process)

    def _begin(
        self, effects: Sequence[Effect], ended: Callable[[Result], None], waiting: _Countdown
    ) -> None:
        """What is gone has ended: start what is new, unless the run has begun to end."""
        if not self.run.shutdown.has_begun:
            self._core_driver.carry_out(effects)
        for effect in effects:
            if not isinstance(effect, StartProcess):
                continue
            process = self._processes.get(effect.process_id)
            if process is not None:
                ended(_begun(process))
            else:
                self._core_driver.not_started(effect.process_id, errno.ECANCELED)
        waiting.done()

    def _finish(
        self, entries: Sequence[ComparedProcess], results: Mapping[str, Result], done: Done
    ) -> None:
        self.is_busy = False
        self._core_driver.nudge()
        done([replace(one, result=results.get(one.name, one.result)) for one in entries])

    def _evaluate(self, edited: Collection[Process] = ()) -> tuple[Evaluation, RunOptions]:
        core = self.core
        if self.run.shutdown.has_begun:
            raise LauncherError("the run is being stopped")
        if self.is_busy:
            raise LauncherError("another reload is being carried out")
        now = self._reactor.now()
        known = [_known(one, now, is_edited=one in edited) for one in self.run.processes]
        options = core.read_options()
        adapt = functools.partial(adapted, options=options)
        elapsed_s = self._core_driver.elapsed_s
        return core.evaluate_again(known, options, adapt, elapsed_s), options

    def _entries(self, reload: Reload, options: RunOptions) -> list[ComparedProcess]:
        now = self.run.options
        kept = [_kept(one, setting_changes(now, options, one.spec)) for one in reload.kept]
        gone = [
            ComparedProcess(self._processes[number].name, Change.GONE) for number in reload.gone
        ]
        new = [ComparedProcess(one.name, Change.NEW, (one.command_line,)) for one in reload.new]
        return [*kept, *gone, *new]


def _kept(one: Kept, settings: Sequence[str]) -> ComparedProcess:
    name = one.spec.name
    if one.postponed:
        result = Result(name, Kind.UNDER_DEBUGGER, done=False)
        return ComparedProcess(name, Change.CHANGED, one.postponed, result)
    changes = (*one.changes, *settings)
    return ComparedProcess(name, Change.CHANGED if changes else Change.SAME, changes)


def _names(entries: Sequence[ComparedProcess]) -> dict[str, tuple[str, ...]]:
    return {
        change.value: tuple(one.name for one in entries if one.change is change)
        for change in Change
    }


def _known(process: Process, now: float, *, is_edited: bool) -> Known:
    machine, end = process.machine, process.last_end
    is_stopped = machine.state is ProcessState.STOPPED
    has_ended = machine.state in (ProcessState.EXITED, ProcessState.FATAL) or (
        is_stopped and not machine.is_held
    )
    return Known(
        process_id=process.process_id,
        name=process.name,
        spec=comparable(process.spec),
        has_started=process.history.starts > 0,
        started_ago_s=0.0 if machine.running_since is None else now - machine.running_since,
        pid=None if process.child is None else process.child.pid,
        is_stopped=is_stopped,
        has_ended=has_ended,
        returncode=end.outcome.returncode if has_ended and end is not None else None,
        ended_ago_s=time.time() - process.ended_wall_s if has_ended else 0.0,
        is_edited=is_edited,
        is_debugged=process.is_debugged,
    )


def serve(request: VerbRequest) -> None:
    """Carry out the request; BadCallError."""
    reloader, exchange = request.run.parts.need(Reloader), request.exchange
    try:
        if request.call.options.get(DRY_RUN.name):
            _answer(exchange, reloader.compare())
        else:
            reloader.reload(lambda entries: _answer(exchange, entries))
    except LaunchFileError as error:
        raise BadCallError("bad-launch-file", _message(error), error.hint) from None
    except LauncherError as error:
        code = "bad-launch-file" if error.exit_code == 2 else "wrong-state"
        raise BadCallError(code, _message(error), error.hint) from None


def _message(error: LauncherError) -> str:
    """The error with its place and line, without its hint."""
    text = error.render().removeprefix("error: ")
    return text.removesuffix(f"\nhint: {error.hint}") if error.hint else text


def _answer(exchange: Exchange, entries: Sequence[ComparedProcess]) -> None:
    exchange.reply({"processes": [_document(one) for one in entries]}, lines(entries))


def _document(one: ComparedProcess) -> dict[str, Any]:
    return {
        "name": one.name,
        "change": one.change.value,
        "details": list(one.details),
        "done": one.result is None or one.result.done,
        "text": "" if one.result is None else sentence(one.result),
    }


def lines(entries: Sequence[ComparedProcess]) -> list[str]:
    """A line for each change, and one for what is the same."""
    changes = [one for one in entries if one.change is not Change.SAME]
    same = [one.name for one in entries if one.change is Change.SAME]
    width = max((len(one.name) for one in changes), default=0)
    text = [_line(one, width) for one in changes]
    if not changes:
        return [f"nothing has changed: {count(len(same), 'process')} as in the launch file"]
    return [*text, f"the same: {', '.join(same)}"] if same else text


def _line(one: ComparedProcess, width: int) -> str:
    line = f"{one.change.value:<7}  {one.name:<{width}}  {'; '.join(one.details)}".rstrip()
    return line if one.result is None else f"{line}\n{'':7}  {sentence(one.result)}"
