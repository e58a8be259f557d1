"""The processes of a run on this host: the launcher's engine, directed by requests."""

from __future__ import annotations

import errno
import functools
import os
import shutil
import signal
from collections.abc import Callable, Mapping, Sequence

from launcher.base.errors import LauncherError
from launcher.base.model.record import as_dict, replace
from launcher.base.model.run_event import RunEvent
from launcher.base.model.run_events import Resources, Sample
from launcher.base.model.spec import ProcessSpec
from launcher.hosts.agent.forwarder import Forwarder
from launcher.hosts.engine.replica import ReportingMachine
from launcher.hosts.file.order import Order
from launcher.output.logs.run_directory import provide_log_root
from launcher.posix.cleanup import RUN_ID_VARIABLE, subreaper
from launcher.posix.cleanup.watchdog_client import WatchdogClient
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import Child, StartSettings, start
from launcher.run.ending.session_end import stop_session
from launcher.run.logs.run_log import RunLog
from launcher.run.processes.machine_events import (
    MachineCommand,
    MachineEvent,
    ReportExit,
    SignalSent,
)
from launcher.run.processes.process import Process
from launcher.run.processes.process_driver import ProcessDriver

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Protocol

    from launcher.base.model.run_events import Sample
    from launcher.hosts.file.resolution import Resolved
    from launcher.run.ending.leftovers import Leftovers
    from launcher.run.monitor.housekeeping import Housekeeper
    from launcher.run.part import StartStage

    class Reporter(Protocol):
        """Where reports go."""

        def event(
            self, process_id: int, event: MachineEvent, at_s: float, pid: int, left_s: float | None
        ) -> None: ...
        def output(self, process_id: int, stream: int, data: bytes) -> None: ...
        def warn(self, text: str) -> None: ...
        def samples(self, samples: Mapping[int, Mapping[str, Any]]) -> None: ...

        # After `end`: everything has been stopped.
        def ended(self, leftovers: Sequence[str], *, killed: bool) -> None: ...

    from launcher.run.logs.messages import Line


TERMINAL_SIZE = (80, 24)  # of pseudo-terminals
MONITOR_AFTER_S = 0.05  # nothing is to delay the first start


class Workload:
    """Starts, signals and watches processes; what its driver needs of a run.

    Files of orders are in `folder`, which is made when the first is needed.
    """

    def __init__(self, reactor: Reactor, reporter: Reporter, folder: str) -> None:
        self.reactor = reactor
        self._reporter = reporter
        # With our pid, as that of each run on this machine: `doctor` checks whether we are alive.
        self.run_id = f"{os.getpid()}-{os.urandom(6).hex()}"
        self._processes: dict[int, Process] = {}
        self._orders: dict[int, Order] = {}
        self._resolved: dict[int, Resolved] = {}
        self._folder = folder
        self.log = AgentRunLog(reporter.warn, self._samples)
        provide_log_root(os.environ, reporter.warn)
        self.reader = Forwarder(reactor, self._processes.values(), reporter.output)
        self.spawner = self
        self.stages: tuple[StartStage, ...] = ()  # the operator's side has them
        self._driver = ProcessDriver(self)
        self._watchdog = WatchdogClient(reactor, self.run_id, reporter.warn)
        self._housekeeper: Housekeeper | None = None
        self._is_ending = False
        self._leftovers: Leftovers | None = None
        self._found: list[str] = []
        self._has_killed = False

    @property
    def is_idle(self) -> bool:
        """Whether no process runs or will be restarted."""
        return not any(process.machine.is_pending for process in self._processes.values())

    # ---- requests

    def prepare(self, process_id: int, order: Order) -> None:
        spec = ProcessSpec(
            name=order.name,
            label=order.label,
            argv=(),
            env={},
            cwd=order.cwd,
            shell=order.shell,
            emulate_tty=order.emulate_tty,
            restart=order.restart,
            stop=order.stop,
            limits=order.limits,
        )
        process = Process(process_id, spec, number=len(self._processes), prefix=b"")
        report = functools.partial(self._report, process)
        process.machine = ReportingMachine(order.restart, order.stop, report)
        self._processes[process_id] = process
        self._orders[process_id] = order

    def _report(
        self, process: Process, event: MachineEvent, at_s: float, left_s: float | None
    ) -> None:
        is_start = event is MachineCommand.STARTED and process.child is not None
        pid = process.child.pid if is_start and process.child is not None else -1
        self._reporter.event(process.process_id, event, at_s, pid, left_s)

    def command(self, process_id: int, command: MachineCommand) -> None:
        """KeyError if the process was not prepared."""
        self._driver.advance(self._processes[process_id], command)

    def signal(self, process_id: int, signum: int, *, by_user: bool) -> None:
        """KeyError if the process was not prepared. Reported even if it does not run."""
        process = self._processes[process_id]
        if process.child is None:
            self._driver.advance(process, SignalSent(signum, by_user=by_user))
        else:
            self._driver.signal(process, signum, by_user=by_user)

    def write_stdin(self, process_id: int, data: bytes) -> None:
        """KeyError if the process was not prepared."""
        process = self._processes[process_id]
        if process.child is None:
            return
        try:
            process.child.write_stdin(data)
        except OSError as error:
            reason = os.strerror(error.errno or 0)
            self._reporter.warn(f"{process.name}: cannot write to its standard input: {reason}")

    # ---- the end

    def end(self, *, at_once: bool = False) -> None:
        """Stop everything, leftovers too, and report `ended`; again with `at_once` to hurry."""
        self._is_ending = True
        self._watchdog.prepare_end()
        for process in reversed(list(self._processes.values())):
            self._driver.advance(process, MachineCommand.STOP)
            if at_once:
                self._driver.advance(process, MachineCommand.SKIP_GRACE)
        if at_once and self._leftovers is not None:
            self._leftovers.skip_grace()
        self.reactor.call_later(0, self.idle)

    def idle(self) -> None:
        machines = [process.machine for process in self._processes.values()]
        is_busy = any(machine.is_pending and not machine.is_stuck for machine in machines)
        if not self._is_ending or is_busy or self._leftovers is not None:
            return
        from launcher.run.ending.leftovers import Leftovers, stop_policy_for

        children = [p.child for p in self._processes.values() if p.machine.is_stuck]
        stuck = frozenset(child.pid for child in children if child is not None)
        self._leftovers = Leftovers(
            self.run_id,
            reactor=self.reactor,
            listener=self,
            ignore=self._watchdog.pids | stuck,
            policy=stop_policy_for(machine.stop for machine in machines),
            kin=subreaper.orphans,
        )
        self._leftovers.check()

    def report(self, level: str, text: str) -> None:
        """Of the leftovers."""
        names = text.partition(": ")[2]
        if names not in self._found:
            self._found.append(names)

    def killing(self) -> None:
        self._has_killed = True

    def finished(self) -> None:
        self._is_ending, self._leftovers = False, None
        found, self._found = self._found, []
        for process in self._processes.values():
            self._driver.read_rest(process)
        self._reporter.ended(found, killed=self._has_killed)

    def close(self) -> None:
        """No process is left, even after an exception."""
        for process in self._processes.values():
            if process.child is not None:
                process.child.signal_group(signal.SIGKILL)
            self._driver.release(process)
        if self._housekeeper is not None:
            self._housekeeper.close()
        self._watchdog.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    # ---- what the driver reports and asks

    def spawn(self, process: Process) -> Child:
        found = self._resolve(process)
        self._watchdog.ensure()
        if self._housekeeper is None:
            self.reactor.call_later(MONITOR_AFTER_S, self._monitor)
        order = self._orders[process.process_id]
        env = {**found.env, RUN_ID_VARIABLE: self.run_id}
        return start(process.spec, StartSettings(env, order.merge, TERMINAL_SIZE))

    def _resolve(self, process: Process) -> Resolved:
        """OSError if the program is not here, or a file cannot be written."""
        found = self._resolved.get(process.process_id)
        if found is None:
            from launcher.hosts.file.resolution import resolve

            order = self._orders[process.process_id]
            folder = os.path.join(self._folder, str(process.process_id))
            if order.files:
                os.makedirs(self._folder, mode=0o700, exist_ok=True)
            try:
                found = resolve(order, folder, os.environ)
            except LauncherError as error:
                raise OSError(errno.ENOENT, error.message) from None
            self._resolved[process.process_id] = found
            process.spec = replace(process.spec, argv=found.argv, cwd=found.cwd)
        return found

    def _monitor(self) -> None:
        if self._housekeeper is not None:
            return
        from launcher.run.monitor.housekeeping import Housekeeper

        self._driver.watch_memory()
        self._housekeeper = Housekeeper(
            self.reactor, self.log, self.run_id, self._processes.values()
        )
        self._housekeeper.start()

    def _samples(self, by_name: Mapping[str, Sample]) -> None:
        ids = {process.name: process.process_id for process in self._processes.values()}
        self._reporter.samples({ids[name]: as_dict(sample) for name, sample in by_name.items()})

    def ended(self, process: Process, pid: int, end: ReportExit) -> None:
        code = end.outcome.returncode
        if code:
            self._monitor()
            assert self._housekeeper is not None
            self._housekeeper.ledger.died(code, process.begun_wall_s)

    def before_kill(self) -> None:
        if self._housekeeper is not None:
            self._housekeeper.ledger.note()

    def may_have_left(self, process: Process, session: int) -> None:
        """Stop what a process that was stopped, or is restarted, left in its session."""
        if self._is_ending:
            return
        stop_session(
            session,
            run_id=self.run_id,
            reactor=self.reactor,
            ignore=self._watchdog.pids,
            stop=process.machine.stop,
            log=lambda _, text: self._reporter.warn(f"{process.name}: {text}"),
            killing=lambda: None,
        )

    def started(self, process: Process, pid: int) -> None: ...
    def cancelled(self, process: Process) -> None: ...


class AgentRunLog(RunLog):
    """What the parts of the engine have to say, for the operator; there are no files.

    Warnings go to `warn`, samples of processes to `samples`. Most else the operator's replica of a
    state machine says itself.
    """

    def __init__(
        self,
        warn: Callable[[str], None],
        samples: Callable[[Mapping[str, Sample]], None],
    ) -> None:
        self._warn = warn
        self._samples = samples

    def log(
        self, level: str, logger: str, text: str, *, sink: str = "", line: str | None = None
    ) -> None:
        if level != "INFO":
            self._warn(text)

    def report(self, process: Process, line: Line) -> None:
        pass

    def keep_up(self) -> None:
        pass

    def note(
        self,
        event: RunEvent,
        process: Process | None = None,
        at_s: float | None = None,
    ) -> None:
        if isinstance(event, Resources):
            self._samples(event.processes)
