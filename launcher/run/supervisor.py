"""Runs one launch file, from the first process to the last."""

from __future__ import annotations

import contextlib
import errno
import functools
import gc
import signal
from collections.abc import Callable, Iterable, Iterator, Mapping

from launcher.base.errors import ExitCode
from launcher.base.model.events import LoadComponent, StartProcess
from launcher.base.model.options import RunOptions
from launcher.base.model.run_events import Finished
from launcher.output.logs.run_directory import RunDirectory
from launcher.output.stdout import StdoutWriter
from launcher.posix import dispositions
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.cleanup.watchdog_client import WatchdogClient
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import (
    Child,
    StartSettings,
    set_close_on_exec,
    start,
    terminal_size_beside,
)
from launcher.run.core_driver import CoreDriver
from launcher.run.logs.run_log import RunLog
from launcher.run.machine import Command, Ended, ProcessState
from launcher.run.output.reader import OutputReader
from launcher.run.process import Process, adapted, child_environment
from launcher.run.process_driver import ProcessDriver

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.events import Event
    from launcher.base.model.spec import ProcessSpec
    from launcher.hosts.engine.fleet import Fleet, FleetPlan
    from launcher.run.core_driver import Core
    from launcher.run.helpers.parameter_checks import ParameterChecks
    from launcher.run.logs.run_log import Wishes
    from launcher.run.monitor.budgets import Judge, Verdict
    from launcher.run.monitor.housekeeping import Housekeeper
    from launcher.run.ready.gate import ReadyGate
    from launcher.run.run_control import RunControl
    from launcher.run.shutdown import Shutdown
    from launcher.run.warm.spawner import WarmSpawner

RESPONSIVE_DELAY_S = 2.0  # nodes are starting before, and cannot be late
PRUNE_S, PRUNE_LEAST = 0.01, 20  # at the end of a run: so long, and at least so many steps
PLAN_DELAY_S = 0.1  # the plan is not urgent, and processes are still starting before
WATCH_DELAY_S = 0.05  # the first processes are started before
KEPT = "The last 20 runs stay there, and all that failed or have a snapshot"


class Supervisor:
    """Composes the parts of a run; they report to it, as a `RunListener`.

    `env` is the environment of the ROS agent; the files of the run go to `run_path`, unless that is
    None. `hosts` says which processes run on other hosts (None: no process), `switched_off` which
    ones a condition keeps away. `on_begun()` is called after the static part of the launch file was
    carried out.
    """

    def __init__(
        self,
        core: Core,
        *,
        env: Mapping[str, str],
        reactor: Reactor,
        screen: StdoutWriter,
        run_id: str,
        run_path: str | None = None,
        options: RunOptions = RunOptions(),  # noqa: B008  (frozen)
        wishes: Wishes | None = None,
        hosts: FleetPlan | None = None,
        switched_off: Callable[[], Iterable[ProcessSpec]] = tuple,
    ) -> None:
        self._core = core
        self._reactor = reactor
        self._screen = screen
        self._run_id = run_id
        self._options = options
        self._processes: dict[int, Process] = {}
        self._control: RunControl | None = None
        self.is_script = False  # it decides on the exit code
        self.on_begun: Callable[[], object] = lambda: None
        processes = self._processes.values()
        warn = functools.partial(screen.log, "WARNING", "launch")
        soon = functools.partial(reactor.call_later, 0)
        self._directory = RunDirectory(run_path, warn, soon=soon)
        self._pruning = self._old_runs()
        self._log = RunLog(reactor, screen, self._directory, wishes)
        self._watchdog = WatchdogClient(reactor, run_id, self._log.warn)
        self._reader = OutputReader(reactor, screen, self._directory, processes, self)
        self._env = env
        self._fleet: Fleet | None = None
        self._driver = self._process_driver(hosts)
        if options.stagger_s > 0 or options.max_starting is not None:
            self._driver.pace(stagger_s=options.stagger_s, most=options.max_starting)
        self._agent_env = {**env, RUN_ID_VARIABLE: run_id, **self._log_dir}
        self._switched_off = switched_off
        self._ready = self._ready_gate()
        self._core_driver = CoreDriver(
            core,
            reactor,
            self._log,
            self._driver,
            self,
            processes=self._processes,
            agent_env=self._agent_env,
        )
        self._warm: WarmSpawner | None = None
        self._is_begun = False
        if options.warm is not False:
            self._driver.warm = self
        screen.on_closed = lambda: self._shutdown.output_closed()
        self._judge = self._budget_judge()

    def _process_driver(self, hosts: FleetPlan | None) -> ProcessDriver:
        if hosts is None:
            return ProcessDriver(self._reactor, self._reader, self._log, self)
        from launcher.hosts.engine.fleet import Fleet

        self._fleet = fleet = Fleet(hosts, self._reactor, self._log, self)
        return fleet.driver(self._reader, self._run_id, self._env, colour=self._screen.colour)

    def _ready_gate(self) -> ReadyGate | None:
        if not self._options.start_rules:
            return None
        from launcher.run.ready.gate import ReadyGate

        gate = ReadyGate(
            self._reactor,
            self._log,
            self._driver,
            self,
            self._options.start_rules,
            env=self._agent_env,
            env_of=lambda process: self.settings_of(process, process.spec).env,
            switched_off=self._switched_off,
        )
        self._driver.order(gate)
        return gate

    def _budget_judge(self) -> Judge | None:
        """UsageError, before anything is started, if a budget is invalid."""
        if not self._options.has_budgets:
            return None
        from launcher.run.monitor.housekeeping import judge_for

        return judge_for(self._options)

    @functools.cached_property
    def _shutdown(self) -> Shutdown:
        """Imported after the first processes have been started."""
        from launcher.run.shutdown import Shutdown

        return Shutdown(
            self._reactor,
            self._log,
            self._driver,
            self._core_driver,
            self._watchdog,
            run_id=self._run_id,
            processes=self._processes.values(),
            close_helpers=self._close_helpers,
            fleet=self._fleet,
            exit_when_any_dies=self._options.exit_when_any_dies,
        )

    @functools.cached_property
    def _housekeeper(self) -> Housekeeper:
        """Imported after the first processes have been started."""
        from launcher.run.monitor.housekeeping import Housekeeper

        return Housekeeper(
            self._reactor,
            self._log,
            self,
            run_id=self._run_id,
            processes=self._processes.values(),
            judge=self._judge,
            fleet=self._fleet,
        )

    @property
    def _log_dir(self) -> dict[str, str]:
        path = self._directory.path
        return {} if path is None else {"ROS_LOG_DIR": path}

    @property
    def control(self) -> RunControl:
        """What the control socket can read and change; made on first use."""
        if self._control is None:
            from launcher.run.run_control import RunControl

            self._control = RunControl(
                self._reactor,
                self._log,
                self._driver,
                self._shutdown,
                self._core,
                self._core_driver,
                options=lambda: self._options,
                follow=self._follow,
                env=self._env,
                is_script=lambda: self.is_script,
                processes=self._processes,
                housekeeper=self._housekeeper,
                log_dir=self._directory.path,
                keep=self._watchdog.keep,
                screen=self._screen,
                fleet=self._fleet,
                ready=self._ready,
            )
        return self._control

    # ---- the run

    def run(self) -> ExitCode:
        """Run to the end, and return the exit code. No process is left even after an exception."""
        with self.running():
            self._reactor.run()
        return self._exit_code()

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        """The run; within, the reactor must run until it is stopped."""
        with contextlib.suppress(ValueError):  # a script runs it in another thread
            dispositions.notice_children()
        self._reactor.on_signals(
            dispositions.ENDING, lambda signum: self._shutdown.interrupt(signum)
        )
        set_close_on_exec()
        self._reactor.on_signals((signal.SIGWINCH,), self._terminal_resized)
        is_orderly = False
        try:
            if self._directory.path is not None:
                path = self._directory.path
                self._log.log("INFO", "launch", f"All log files can be found below {path}")
                self._log.log("INFO", "launch", KEPT)
            if self._fleet is None:
                self._begin()
            else:
                self._fleet.open(self._begin)
                self.idle()
            yield
            is_orderly = True
        finally:
            self._clean_up(is_orderly=is_orderly)

    @property
    def stop_signal(self) -> int | None:
        """The first signal that ended the run."""
        return self._shutdown.stop_signal

    def feed(self, event: Event) -> None:
        """Pass an event to the core from outside, in the thread of the reactor."""
        self._core_driver.feed(event)
        self._shutdown.idle()

    def stay_while(self, condition: Callable[[], bool]) -> None:
        """Do not end for want of processes while this is true."""
        self._core_driver.stays = condition

    def _exit_code(self) -> ExitCode:
        return ExitCode.PROCESS_FAILED if self._core.has_failed else self._shutdown.exit_code()

    def _summarize(self) -> None:
        from launcher.run.logs import summary

        summary.conclude(
            self._log,
            self._screen,
            list(self._processes.values()),
            self._shutdown,
            code=self._exit_code(),
            has_exception=self._core.has_failed,
            is_script=self.is_script,
        )

    def _begin(self) -> None:
        timeout_s = self._options.timeout_s
        if timeout_s is not None:
            reason = f"timeout of {timeout_s:g} s reached"
            self._reactor.call_later(timeout_s, lambda: self._shutdown.stop(reason))
        self._reactor.when_idle(self.idle)  # first: it imports what the exit of a process needs
        with self._screen.collecting(), self._directory.collecting():
            self._core_driver.start()
            self._is_begun = True
            if self._warm is not None:
                self._warm.settle()
        for what in (
            lambda: self._housekeeper.start(),
            self._driver.watch_memory,
            _settle,
            self._prune,
        ):
            self._reactor.when_idle(what)
        self._reactor.call_later(PLAN_DELAY_S, self._write_plan)
        if self._options.watch:
            self._reactor.call_later(WATCH_DELAY_S, self._watch)
        if self._options.responsive:
            self._reactor.call_later(RESPONSIVE_DELAY_S, self._watch_nodes)
        self.on_begun()

    def _old_runs(self) -> Iterator[None]:
        """Delete old runs, one in each step."""
        from launcher.output.logs.old_runs import prune

        if self._directory.path is not None:
            yield from prune(self._directory.path)

    def _prune(self) -> None:
        if next(self._pruning, "over") is None:
            self._reactor.when_idle(self._prune)

    def _prune_rest(self) -> None:
        """A run of some milliseconds has no idle moment: go on for a little while."""
        until_s = self._reactor.now() + PRUNE_S
        for step, _ in enumerate(self._pruning, 1):
            # However slow the machine is, such runs must not leave more than they delete.
            if step >= PRUNE_LEAST and self._reactor.now() >= until_s:
                break

    def _watch(self) -> None:
        if not self._shutdown.has_begun:
            self.control.watching.turn(None, on=True)

    def _watch_nodes(self) -> None:
        if not self._shutdown.has_begun:
            self.control.responsiveness.look(float("inf"))

    def _clean_up(self, *, is_orderly: bool) -> None:
        for process in self._processes.values():
            if process.child is not None:
                # Only after an exception: an orderly end has reaped every child.
                process.child.signal_group(signal.SIGKILL)
            self._driver.release(process)
        self._close_helpers()
        self._housekeeper.close()
        self._watchdog.close()
        if self._fleet is not None:
            self._fleet.close(is_orderly=is_orderly)
        self._write_plan()
        if is_orderly:
            self._summarize()  # as the last lines
        deaths = sum(process.history.deaths for process in self._processes.values())
        self._log.note(Finished(int(self._exit_code()), deaths))
        lost_lines = self._screen.finish()
        if lost_lines:
            text = f"{lost_lines} lines were not shown: nobody read the output any more"
            self._directory.log("WARNING", "launch", text)
        if self._screen.dropped_bytes:
            text = f"dropped {self._screen.dropped_bytes} bytes of output: the disk was full"
            self._directory.log("WARNING", "launch", text)
        self._directory.close()
        if is_orderly:
            self._prune_rest()

    def _close_helpers(self) -> None:
        self._core_driver.close_requests()
        if self._control is not None:
            self._control.close()
        if self._warm is not None:
            self._warm.close()
        if "_checks" in vars(self):
            self._checks.close()
        if self._ready is not None:
            self._ready.close()

    def _write_plan(self) -> None:
        self._directory.write_plan(self._core.plan)
        if self._options.name_processes:
            from launcher.run.option_warnings import warn_of_unmatched

            specs, is_over = [p.spec for p in self._processes.values()], self._shutdown.has_begun
            specs += self._switched_off()
            warn_of_unmatched(self._options, specs, self._log, is_over=is_over)

    def _terminal_resized(self, signum: int) -> None:
        for process in self._processes.values():
            if process.child is not None:
                process.child.resize(terminal_size_beside(len(process.name) + 3))

    # ---- requests of the core

    def _follow(self, options: RunOptions) -> None:
        """Apply options that a reload has read, as far as they are not in the specs."""
        before, self._options = self._options, options
        if options.file_budgets != before.file_budgets:
            self._housekeeper.judge = self._budget_judge()
        if options.start_rules == before.start_rules:
            return
        if self._ready is not None:
            self._ready.follow(options.start_rules)
            return
        gate = self._ready = self._ready_gate()
        assert gate is not None and self._control is not None
        self._control.ready = gate
        for process in self._processes.values():
            if not process.is_gone:
                gate.join(process)

    def start(self, effect: StartProcess) -> None:
        number = len(self._processes)
        spec = adapted(effect.spec, self._options)
        if self._fleet is not None and self._fleet.refuses(spec):
            self._core_driver.not_started(effect.process_id, errno.ECANCELED)
            return
        prefix = self._screen.prefix(spec, number)
        process = Process(effect.process_id, spec, number=number, prefix=prefix)
        self._processes[effect.process_id] = process
        if spec.members:
            from launcher.run.compose.members import follow_members

            follow_members(process, self._screen, self._log, self._core_driver.feed)
        if self._fleet is not None:
            self._fleet.place(process, merge=self._merges(process))
        if self._control is not None:
            self._control.adopt(process)
        if self._ready is not None:
            self._ready.add(process)
        self._driver.advance(process, Command.START)
        if (spec.ros or spec.members) and self._options.check_parameters:
            self._checks.later()

    def loaded(self, effect: LoadComponent, full_name: str) -> None:
        if effect.request.parameters and self._options.check_parameters:
            self._checks.loaded(effect, full_name)

    @functools.cached_property
    def _checks(self) -> ParameterChecks:
        """Imported after the first process has been started."""
        from launcher.run.helpers.parameter_checks import ParameterChecks

        processes = self._processes.values()
        return ParameterChecks(self._reactor, self._env, self._log.warn, processes)

    def shut_down(self, reason: str, *, is_interrupted: bool) -> None:
        if "_checks" in vars(self):
            self._checks.leave()
        self._shutdown.decided(reason, is_interrupted=is_interrupted)

    def watches(self, process: Process) -> bool:
        return self._core_driver.watches(process)

    def output(self, process: Process, stream: str, data: bytes) -> None:
        self._core_driver.output(process, stream, data)

    # ---- events of processes

    def spawn(self, process: Process) -> Child:
        self._watchdog.ensure()
        spec = process.take_debugger()
        return start(spec, self.settings_of(process, spec))

    def settings_of(self, process: Process, spec: ProcessSpec) -> StartSettings:
        """How a process is started that runs `spec`."""
        env = child_environment(
            spec,
            run_id_entry=(RUN_ID_VARIABLE, self._run_id),
            log_dir=self._directory.path,
            colour=self._screen.colour,
        )
        is_tty = spec.emulate_tty
        size = terminal_size_beside(len(process.name) + 3) if is_tty else None
        return StartSettings(env, merge=self._merges(process), terminal_size=size)

    # ---- warm starts, by a package that is imported for the first process that may have one

    def admit(self, process: Process) -> bool:
        spec = process.spec
        if not (self._options.warm or spec.ros):
            return False
        if self._warm is None:
            if process.next_debugger:
                return False
            from launcher.packages.python_program import program_of

            program = program_of(spec.argv, spec.env, spec.cwd)
            if isinstance(program, str):
                process.start_kind = f"cold, because {program}"
                return False
            from launcher.run.warm.spawner import WarmSpawner

            self._watchdog.ensure()  # which adopts orphans from now on
            self._warm = WarmSpawner(
                self._reactor,
                self._driver,
                settings_of=self.settings_of,
                warn=self._log.warn,
                is_forced=bool(self._options.warm),
                is_interactive=self._options.watch
                or (self._options.console and self._screen.is_tty),
                is_begun=self._is_begun,
                held=self._held_back,
            )
        return self._warm.admit(process)

    def _held_back(self) -> list[Process]:
        """Those whose start was asked for, and that wait for others or for their turn."""
        wanted = [one for one in self._processes.values() if self._options.warm or one.spec.ros]
        return [
            one
            for one in wanted
            if one.machine.state is ProcessState.STARTING and one.child is None
        ]

    def withdraw(self, process: Process) -> bool:
        return self._warm is not None and self._warm.withdraw(process)

    def is_starting(self, process: Process) -> bool:
        return self._warm is not None and self._warm.is_starting(process)

    def awaits_preparation(self, process: Process) -> bool:
        return self._warm is not None and self._warm.awaits_preparation(process)

    def _merges(self, process: Process) -> bool:
        return process.streams_can_merge and not self.watches(process)

    def awaited_facts(self, process: Process) -> list[str]:
        return [] if self._ready is None else self._ready.awaited_facts(process)

    def started(self, process: Process, pid: int) -> None:
        process.is_replaced = False
        if self._ready is not None:
            self._ready.started(process)
        self._core_driver.started(process, pid)
        if self._control is not None:
            self._control.started(process)
        self._notify_control()

    def ended(self, process: Process, pid: int, end: Ended) -> None:
        if self._ready is not None:
            self._ready.ended(process, end)
        self._notify_control()
        code = end.outcome.returncode
        if code and process.host is None:
            since_s = process.begun_wall_s
            if "_housekeeper" in vars(self):
                self._housekeeper.died(code, since_s)
            else:  # a restart does not wait for its import
                self._reactor.when_idle(lambda: self._housekeeper.died(code, since_s))
        self._shutdown.ended(process, end, is_required=self._options.is_required(process.spec))
        self._core_driver.ended(process, pid, end)

    def cancelled(self, process: Process) -> None:
        self._core_driver.cancelled(process)

    def before_kill(self) -> None:
        self._housekeeper.note_shared_memory()

    def may_have_left(self, process: Process, session: int) -> None:
        self._shutdown.end_session(process, session)

    def stop(self, reason: str) -> None:
        self._shutdown.stop(reason)

    def host_failed(self, cause: str) -> None:
        self._shutdown.host_failed(cause)

    def idle(self) -> None:
        if self._fleet is None or not self._fleet.is_connecting:
            self._shutdown.idle()
        self._notify_control()

    def _notify_control(self) -> None:
        if self._control is not None:
            self._control.changed()

    def over_budget(self, process: Process, verdict: Verdict) -> None:
        from launcher.run.monitor.housekeeping import enforce

        enforce(process, verdict, self._log, self._driver, self._shutdown)


def _settle() -> None:
    """Exclude what exists now from garbage collection: a full one would take milliseconds."""
    gc.freeze()
    gc.enable()
