"""Supervisor: one run. Carries out what the interpreter asks for, and brings it to its end."""

from __future__ import annotations

import functools
import gc
import signal
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from launcher.engine import report
from launcher.engine.chronicle import Chronicle
from launcher.engine.ending import Ending
from launcher.engine.execution import keep_to_ourselves
from launcher.engine.guard import Guards
from launcher.engine.keeper import Keeper
from launcher.engine.machine import Ended, Restart, Start, Stop
from launcher.engine.process import Process, child_environment, with_sound_name
from launcher.engine.reactor import Reactor, Timer
from launcher.engine.relay import Relay
from launcher.engine.runfolder import RunFolder
from launcher.engine.screen import Screen
from launcher.engine.spawn import Child, spawn, terminal_size_beside
from launcher.engine.sweep import RUN_ID_VARIABLE
from launcher.errors import ExitCode
from launcher.model.events import (
    CallLater,
    CancelTimer,
    ChangeState,
    Effect,
    Event,
    LoadComponent,
    LogMessage,
    ProcessOutput,
    RequestShutdown,
    SignalProcess,
    StartProcess,
    StopProcess,
    TimerFired,
    WatchLifecycle,
    WriteStdin,
)
from launcher.model.options import RunOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.engine.budgets import Judge, Verdict
    from launcher.engine.caretaker import Caretaker
    from launcher.engine.core import Core
    from launcher.engine.desk import Desk
    from launcher.engine.ros_agent import RosAgent

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
LAST_LINES = 10  # of the process that died first, in the summary
PLAN_DELAY_S = 0.1  # nobody waits for it, and processes are still starting before
LAST_WORDS_S = 2.0  # how long a slow reader of our output is waited for at the end


class Supervisor:
    """One run, from the first process to the last. `run()` returns the exit code.

    `env` is what the plan is compared with; the files of the run go to `run_path`, if there is one.
    `on_begun()` is called when the static part of the launch file has been carried out.
    """

    def __init__(
        self,
        core: Core,
        *,
        env: Mapping[str, str],
        reactor: Reactor,
        screen: Screen,
        run_id: str,
        run_path: Path | None = None,
        options: RunOptions = RunOptions(),  # noqa: B008  (frozen)
    ) -> None:
        self._core = core
        self._env = env
        self._reactor = reactor
        self._screen = screen
        self._run_id = run_id
        self._options = options
        self._processes: dict[int, Process] = {}
        self._watching: dict[int, bool] = {}
        self._timers: dict[int, Timer] = {}
        self._inbox: deque[Event] = deque()
        self._busy = False
        self._agent: RosAgent | None = None
        self._desk: Desk | None = None
        self.on_begun: Callable[[], object] = lambda: None
        trouble = functools.partial(screen.log, "WARNING", "launch")
        soon = functools.partial(reactor.call_later, 0)
        self._folder = RunFolder(run_path, trouble, soon=soon)
        self._chronicle = Chronicle(reactor, screen, self._folder)
        self._say = self._chronicle.say
        warn = functools.partial(self._say, "WARNING", "launch")
        self._guards = Guards(reactor, run_id, warn)
        self._relay = Relay(
            reactor, screen, self._folder, watched=self._is_watched, watcher=self._output
        )
        self._keeper = Keeper(
            reactor,
            self._relay,
            self._chronicle,
            start_child=self._start_child,
            on_event=self._feed,
            on_end=self._process_ended,
            on_idle=lambda: self._ending.finish_if_done(),
            before_kill=lambda: self._caretaker.note_shared_memory(),
            on_left=lambda process, pid: self._ending.clear_after(process, pid),
        )
        if options.stagger_s > 0 or options.max_starting is not None:
            self._keeper.pace(stagger_s=options.stagger_s, most=options.max_starting)
        self._judge = self._budget_judge()
        self._ending = Ending(
            reactor,
            self._chronicle,
            self._keeper,
            run_id=run_id,
            guards=self._guards,
            processes=self._processes.values,
            tell=self._feed,
            expects_more=self._expects_more,
            on_stop=self._cancel_timers,
            on_empty=self._close_agent,
        )
        screen.on_pressure = lambda pressed: self._relay.pause(pressed, self._processes.values())
        screen.on_closed = self._ending.output_closed

    def _budget_judge(self) -> Judge | None:
        """At once, since a budget that cannot be read ends a run before it begins; UsageError."""
        if not self._options.has_budgets:
            return None
        from launcher.engine.caretaker import judge_for

        return judge_for(self._options)

    @functools.cached_property
    def _caretaker(self) -> Caretaker:
        """Made when the first processes have been started, which need not wait for it."""
        from launcher.engine.caretaker import Caretaker

        return Caretaker(
            self._reactor,
            self._chronicle,
            run_id=self._run_id,
            processes=self._processes.values,
            heard_s=lambda: self._relay.heard_s,
            judge=self._judge,
            act=self._over_budget,
        )

    @property
    def desk(self) -> Desk:
        """Where a person steers the run; made when it is asked for, since most runs need none."""
        if self._desk is None:
            from launcher.engine.desk import Desk

            self._desk = Desk(
                self._reactor,
                self._chronicle,
                self._keeper,
                self._ending,
                self._core,
                processes=self._processes,
                caretaker=self._caretaker,
                log_path=self._folder.path,
            )
        return self._desk

    # ---- the run

    def run(self) -> ExitCode:
        """Start, serve, stop. Whatever happens, nothing is left when this returns."""
        self._reactor.on_signals(STOP_SIGNALS, self._ending.signalled)
        keep_to_ourselves()
        self._reactor.on_signals((signal.SIGWINCH,), lambda signum: self._terminal_resized())
        try:
            if self._folder.path is not None:
                self._say("INFO", "launch", f"All log files can be found below {self._folder.path}")
            self._begin()
            self._ending.finish_if_done()
            self._reactor.run()
            if self._ending.first_death is not None:
                self._say("ERROR", "launch", self._ending.first_death)
        finally:
            self._clean_up()
        return self._ending.exit_code()

    def _begin(self) -> None:
        """Carry out the static part as a whole before the first answer is handled."""
        if self._options.timeout_s is not None:
            self._reactor.call_later(self._options.timeout_s, self._time_is_over)
        self._busy = True
        self._carry_out(self._core.start())
        self._busy = False
        self._pump()
        self._reactor.call_later(0, self._keeper.watch_memory)
        self._reactor.call_later(0, _settle)
        self._reactor.call_later(PLAN_DELAY_S, self._write_plan)
        self._reactor.call_later(0, self._folder.prune)
        self._caretaker.start()
        self.on_begun()

    def _clean_up(self) -> None:
        for process in self._processes.values():
            if process.child is not None:
                # Only after an error of our own: an orderly end has seen every child go.
                process.child.signal_group(signal.SIGKILL)
            self._keeper.let_go(process)
        self._close_agent()
        self._caretaker.close()
        self._guards.close()
        self._write_plan()
        self._chronicle.note("finished", exit_code=int(self._ending.exit_code()))
        self._screen.finish(LAST_WORDS_S)
        if self._screen.dropped_bytes:
            text = f"{self._screen.dropped_bytes} bytes of output found no room on their disk"
            self._folder.log("WARNING", "launch", text)
        self._folder.close()

    def _close_agent(self) -> None:
        if self._agent is not None:
            self._agent.close()
            self._agent = None

    def _write_plan(self) -> None:
        self._folder.write_plan(self._core.plan)
        if self._options.name_processes:
            from launcher.engine.unmatched import warn_of_unmatched

            specs, is_over = [p.spec for p in self._processes.values()], self._ending.has_begun
            warn_of_unmatched(self._options, specs, self._chronicle, is_over=is_over)

    # ---- the interpreter

    def _feed(self, event: Event) -> None:
        """Tell the interpreter, once what it asked for before has been carried out."""
        self._inbox.append(event)
        self._pump()

    def _pump(self) -> None:
        if self._busy:
            return  # whoever is busy, below us on the stack, goes on with the inbox
        self._busy = True
        while self._inbox:
            effects = self._core.handle(self._inbox.popleft())
            self._watching.clear()  # a handler may have come or gone
            self._carry_out(effects)
        self._busy = False

    def _carry_out(self, effects: Sequence[Effect]) -> None:
        for effect in effects:
            match effect:
                case StartProcess():
                    self._start(effect)
                case CallLater(timer_id=timer_id, delay_s=delay_s):
                    fire = functools.partial(self._fire, timer_id)
                    self._timers[timer_id] = self._reactor.call_later(delay_s, fire)
                case CancelTimer(timer_id=timer_id):
                    if timer_id in self._timers:
                        self._timers.pop(timer_id).cancel()
                case LogMessage(logger=logger, level=level, text=text):
                    self._say(level, logger, text)
                case LoadComponent() | ChangeState() | WatchLifecycle():
                    self._ask_ros(effect)
                case RequestShutdown():
                    self._ending.stop_all(effect.reason)
                case SignalProcess() | StopProcess() | WriteStdin():
                    process = self._processes.get(effect.process_id)
                    if process is not None:  # else: a stop came before its start
                        self._steer(process, effect)

    def _steer(self, process: Process, effect: SignalProcess | StopProcess | WriteStdin) -> None:
        match effect:
            case SignalProcess(signum=signum):
                self._keeper.signal(process, signum)
            case StopProcess():
                self._keeper.advance(process, Stop())
            case WriteStdin(data=data):
                self._keeper.write_stdin(process, data)

    def _ask_ros(self, request: LoadComponent | ChangeState | WatchLifecycle) -> None:
        if self._agent is None:
            from launcher.engine.ros_agent import RosAgent

            env = {**self._env, RUN_ID_VARIABLE: self._run_id, **self._log_dir()}
            self._agent = RosAgent(self._reactor, env, self._ros_answered)
        self._agent.send(request)

    def _ros_answered(self, event: Event) -> None:
        self._feed(event)
        self._ending.finish_if_done()

    def _log_dir(self) -> dict[str, str]:
        path = self._folder.path
        return {} if path is None else {"ROS_LOG_DIR": str(path)}

    def _fire(self, timer_id: int) -> None:
        self._timers.pop(timer_id, None)
        self._feed(TimerFired(timer_id=timer_id))
        self._ending.finish_if_done()

    def _is_watched(self, process: Process) -> bool:
        """Asked for each read; the interpreter's answer holds until its next event."""
        number = process.process_id
        if number not in self._watching:
            self._watching[number] = self._core.watches_output(number)
        return self._watching[number]

    def _output(self, process: Process, stream: str, data: bytes) -> None:
        stream = "stdout" if stream == "both" else stream
        self._feed(ProcessOutput(process_id=process.process_id, stream=stream, data=data))

    # ---- processes

    def _start(self, effect: StartProcess) -> None:
        number = len(self._processes)
        spec = with_sound_name(self._options.adapt(effect.spec))
        prefix = self._screen.prefix(spec.name, number)
        process = Process(effect.process_id, spec, number=number, prefix=prefix)
        self._processes[effect.process_id] = process
        if self._desk is not None:
            self._desk.adopt(process)
        self._keeper.advance(process, Start())

    def _start_child(self, process: Process) -> Child:
        path = self._folder.path
        env = child_environment(
            process.spec,
            run_id_entry=(RUN_ID_VARIABLE, self._run_id),
            log_dir=None if path is None else str(path),
            colour=self._screen.colour,
        )
        merge = process.streams_can_merge and not self._is_watched(process)
        is_tty = process.spec.emulate_tty
        size = terminal_size_beside(len(process.name) + 3) if is_tty else None
        self._guards.ensure()
        return spawn(process.spec, env=env, merge=merge, terminal_size=size)

    def _terminal_resized(self) -> None:
        for process in self._processes.values():
            if process.child is not None:
                process.child.resize(terminal_size_beside(len(process.name) + 3))

    def _process_ended(self, process: Process, end: Ended) -> None:
        if end.outcome.returncode is not None and end.outcome.returncode < 0:
            self._caretaker.died_by_signal()
        if self._desk is not None:
            self._desk.operator.changed()
        is_final = end.retry_in_s is None and not end.asked
        died = is_final and end.outcome.failed
        if died and self._ending.first_death is None:
            last_lines = process.last_lines(LAST_LINES)
            what = str(end.outcome)
            self._ending.first_death = report.first_death(process.name, what, last_lines)
        if is_final and self._options.is_required(process.spec):
            self._ending.stop_soon(f"{process.name} is required and has ended")
        elif died and self._options.exit_when_any_dies:
            self._ending.stop_soon(f"{process.name} died")

    def _over_budget(self, process: Process, verdict: Verdict) -> None:
        from launcher.engine.budgets import BudgetAction

        self._say("WARNING", process.name, str(verdict))
        self._chronicle.note("over budget", process, action=verdict.action.value)
        if verdict.action is BudgetAction.RESTART:
            self._keeper.advance(process, Restart())
        elif verdict.action is BudgetAction.STOP_RUN:
            self._ending.first_death = self._ending.first_death or str(verdict)
            self._ending.stop_soon(f"{process.name} is over its budget")

    # ---- the end

    def _time_is_over(self) -> None:
        text = f"the time of {self._options.timeout_s:g} s is over"
        self._say("INFO", "launch", text)
        self._ending.shut_down(text)

    def _expects_more(self) -> bool:
        """Whether something but the processes may still bring about a start."""
        if self._timers or self._inbox or self._busy:
            return True
        is_loading = self._agent is not None and self._agent.is_loading
        return is_loading and not self._ending.has_begun

    def _cancel_timers(self) -> None:
        for timer in self._timers.values():
            timer.cancel()
        self._timers.clear()


def _settle() -> None:
    """Spare the garbage collector what lives as long as the run: a full one takes milliseconds."""
    gc.freeze()
    gc.enable()
