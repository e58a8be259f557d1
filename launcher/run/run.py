"""What everything in one run shares, and what its processes report."""

from __future__ import annotations

import functools
import os
import time

from launcher.base.model.record import Record
from launcher.base.option import load
from launcher.output.logs.run_directory import RunDirectory
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.cleanup.watchdog_client import WatchdogClient
from launcher.posix.spawn import StartSettings, start
from launcher.run.core_driver import CoreDriver
from launcher.run.logs.run_log import RunLog
from launcher.run.output.output_reader import OutputReader
from launcher.run.part import Part, PartRow, StartStage, When
from launcher.run.parts import ROWS
from launcher.run.processes.process import child_environment
from launcher.run.processes.process_driver import ProcessDriver

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
    from typing import TypeVar

    from launcher.base.model.run_options import RunOptions
    from launcher.base.model.spec import ProcessSpec
    from launcher.language.launch_session import LaunchSession
    from launcher.output.stdout import StdoutWriter
    from launcher.posix.reactor import Reactor
    from launcher.posix.spawn import Child
    from launcher.run.core_driver import Core
    from launcher.run.ending.shutdown import Shutdown
    from launcher.run.monitor.housekeeping import Housekeeper
    from launcher.run.processes.machine_events import ReportExit
    from launcher.run.processes.process import Process
    from launcher.run.requests.process_control import ProcessControl

    P = TypeVar("P", bound=Part)

_RANKS = {row.part: rank for rank, row in enumerate(ROWS)}


class Launched(Record):
    """What is run: a `target` with its arguments, as clients of the run see it.

    The files of the run go to `path`, unless that is None. `switched_off` are processes that a
    condition keeps away. `is_script`: a script with a LaunchService, which decides on the exit
    code; `is_test`: of a test, which also says which exits it expects. `hosts` is for the part
    that runs processes elsewhere. `run_id`: that of an earlier run, whose processes are taken over;
    `not_begun` is reported if that is not possible.
    """

    target: str
    arguments: tuple[str, ...] = ()
    path: str | None = None
    session: LaunchSession | None = None
    switched_off: Callable[[], Iterable[ProcessSpec]] = tuple
    is_script: bool = False
    is_test: bool = False
    hosts: object = None
    run_id: str | None = None
    not_begun: str = "nothing was started"


class Run:
    """One run; `env` is the environment of the launcher, which helper processes get.

    `socket` is the path of its control socket, if there is one; `is_begun`: the static part of the
    launch file was carried out.
    """

    # For mypy, since the rows of `launcher.run.parts` read these while this module is checked.
    launched: Launched
    options: RunOptions
    screen: StdoutWriter

    def __init__(
        self,
        core: Core,
        reactor: Reactor,
        screen: StdoutWriter,
        options: RunOptions,
        launched: Launched,
        env: Mapping[str, str],
    ) -> None:
        self.core = core
        self.reactor = reactor
        self.screen = screen
        self.options = options
        self.launched = launched
        self.env = env
        self.id = launched.run_id or f"{os.getpid()}-{os.urandom(4).hex()}"
        self.started_wall_s = time.time()
        self.is_begun = False
        self.socket: str | None = None
        self.all_processes: dict[int, Process] = {}
        name = launched.session.log_name if launched.session is not None else "launch"
        warn = functools.partial(screen.log, "WARNING", name)
        soon = functools.partial(reactor.call_later, 0)
        self.directory = RunDirectory(launched.path, warn, soon=soon, name=name)
        self.log = RunLog(reactor, screen, self.directory, launched.session)
        self.watchdog = WatchdogClient(reactor, self.id, self.log.warn)
        self.core_driver = CoreDriver(self)
        self.reader = OutputReader(
            reactor, screen, self.directory, self.all_processes.values(), self.core_driver
        )
        self.spawner = Spawner(self)
        self.parts = RunParts(self)
        self.parts.make_first()  # which may supply the driver, and do not have it yet
        drivers = (part.driver() for part in self.parts)
        self.driver = next(filter(None, drivers), None) or ProcessDriver(self)

    @property
    def log_dir(self) -> str | None:
        return self.directory.path

    @property
    def stages(self) -> Sequence[StartStage]:
        return self.parts.stages

    @functools.cached_property
    def agent_env(self) -> dict[str, str]:
        """The environment of what talks to nodes for this run."""
        where = {} if self.log_dir is None else {"ROS_LOG_DIR": self.log_dir}
        return {**self.env, RUN_ID_VARIABLE: self.id, **where}

    @property
    def has_nodes(self) -> bool:
        """Whether the launch file has made any, started or not; True if that is not known."""
        session = self.launched.session
        return session is None or session.nodes_made > 0

    @property
    def processes(self) -> list[Process]:
        """All of the launch file, in order of first start."""
        return [one for one in self.all_processes.values() if not one.is_gone]

    @functools.cached_property
    def shutdown(self) -> Shutdown:
        """Imported after the first processes have been started."""
        from launcher.run.ending.shutdown import Shutdown

        return Shutdown(self)

    @property
    def housekeeper(self) -> Housekeeper:
        """Imported after the first processes have been started."""
        from launcher.run.monitor.housekeeping import Housekeeping

        return self.parts.need(Housekeeping).keeper

    @property
    def process_control(self) -> ProcessControl:
        """Imported with the first request."""
        from launcher.run.requests.process_control import ProcessControl

        return self.parts.need(ProcessControl)

    def adopt_helper(self, pid: int) -> None:
        """A helper process that may outlive a killed launcher, and exits by itself."""
        self.watchdog.keep(pid)
        self.housekeeper.ledger.helper_pids.add(pid)

    def follow(self, options: RunOptions) -> None:
        """Apply options that a reload has read, as far as they are not in the specs."""
        before, self.options = self.options, options
        self.parts.make_first()
        for part in self.parts:
            part.follow(before)

    def stay_while(self, condition: Callable[[], bool]) -> None:
        """Do not end for want of processes while this is true; a script decides that itself."""
        if not self.launched.is_script:
            self.core_driver.stay_while(condition)

    # ---- what the driver of the processes reports

    def started(self, process: Process, pid: int) -> None:
        """Its program runs."""
        process.is_replaced = False
        for part in self.parts:
            part.started(process)
        self.core_driver.started(process, pid)
        self.changed()

    def ended(self, process: Process, pid: int, end: ReportExit) -> None:
        """It has exited, which is logged; `pid` is -1 if it could not be started."""
        for part in self.parts:
            part.ended(process, end)
        self.changed()
        self.shutdown.ended(process, end, is_required=self.options.is_required(process.spec))
        self.core_driver.ended(process, pid, end)

    def cancelled(self, process: Process) -> None:
        """It was stopped while it was queued to start."""
        self.shutdown.has_cancelled = True
        self.core_driver.cancelled(process)

    def before_kill(self) -> None:
        """A process is about to get SIGKILL."""
        self.housekeeper.ledger.note()

    def may_have_left(self, process: Process, session: int) -> None:
        """It has exited, and leftovers in its session are to be stopped."""
        self.shutdown.end_session(process, session)

    def idle(self) -> None:
        """An event has been handled completely: the run may be over."""
        if not any(part.holds_run() for part in self.parts):
            self.shutdown.idle()
        self.changed()

    def changed(self) -> None:
        """The state of a process may have changed."""
        for part in self.parts:
            part.changed()


class Spawner:
    """One for a run: executes the program of a process, if that is on this machine."""

    def __init__(self, run: Run) -> None:
        self._run = run

    def spawn(self, process: Process) -> Child:
        """Start its program; OSError."""
        self._run.watchdog.ensure()
        spec = process.take_spec()
        return start(spec, self.settings_of(process, spec))

    def settings_of(self, process: Process, spec: ProcessSpec) -> StartSettings:
        """How a process is started that runs `spec`."""
        session = self._run.launched.session
        env = child_environment(
            spec,
            self._run.env if session is None else session.environment,
            run_id_entry=(RUN_ID_VARIABLE, self._run.id),
            log_dir=self._run.log_dir,
            colour=self._run.screen.colour,
        )
        size = None
        if spec.emulate_tty:
            from launcher.posix.pseudo_terminals import size_beside

            size = size_beside(len(process.name) + 3)
        return StartSettings(env, merge=self.merges(process), terminal_size=size)

    def merges(self, process: Process) -> bool:
        """Whether its two streams are one."""
        return process.streams_can_merge and not self._run.core_driver.watches(process)


class RunParts:
    """The parts of one run, in the order of the table."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._parts: tuple[Part, ...] = ()
        self.stages: Sequence[StartStage] = ()

    def __iter__(self) -> Iterator[Part]:
        return iter(self._parts)

    def find(self, kind: type[P]) -> P | None:
        """The part of this class, if it was made."""
        return next((part for part in self._parts if type(part) is kind), None)

    def need(self, kind: type[P]) -> P:
        """The part of this class, which is made if there is none yet."""
        found = self.find(kind)
        if found is not None:
            return found
        part = kind(self._run)
        self._parts = tuple(sorted((*self._parts, part), key=_rank))
        self.stages = [one for one in self._parts if isinstance(one, StartStage)]
        return part

    def _wanted(self, when: When) -> list[PartRow]:
        return [row for row in ROWS if row.when is when and row.wanted(self._run)]

    def make_first(self) -> None:
        """Make the parts that are wanted before the first start; UsageError."""
        for row in self._wanted(When.FIRST):
            self.need(load(row.part))

    def begin(self, when: When) -> None:
        """Make those that are wanted from then on, in idle moments."""
        for row in self._wanted(when):
            begin = functools.partial(self._begin, row)
            if row.delay_s:
                self._run.reactor.call_later(row.delay_s, begin)
            else:
                begin()

    def _begin(self, row: PartRow) -> None:
        when_idle = self._run.reactor.when_idle
        for name in row.imports:
            when_idle(functools.partial(__import__, name))
        when_idle(lambda: self.need(load(row.part)).begin())


def _rank(part: Part) -> int:
    kind = type(part)
    return _RANKS[f"{kind.__module__}:{kind.__qualname__}"]
