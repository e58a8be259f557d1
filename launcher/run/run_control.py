"""What the control socket can read and change of a run."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping

from launcher.base.errors import LauncherError
from launcher.base.model.record import Record
from launcher.base.model.run_events import Asked
from launcher.output.stdout import StdoutWriter
from launcher.posix.reactor import Reactor
from launcher.run.logs.run_log import RunLog
from launcher.run.output.screen_filters import ScreenFilters
from launcher.run.process import Process
from launcher.run.process_control import ProcessControl
from launcher.run.process_driver import ProcessDriver
from launcher.run.shutdown import Shutdown

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.options import RunOptions
    from launcher.base.model.run_events import Sample
    from launcher.hosts.engine.fleet import Fleet
    from launcher.run.core_driver import Core, CoreDriver
    from launcher.run.helpers.flight_recorder import FlightRecorder
    from launcher.run.helpers.logger_levels import LoggerLevels
    from launcher.run.helpers.web_page import WebPage
    from launcher.run.monitor.housekeeping import Housekeeper
    from launcher.run.monitor.responsiveness import Responsiveness
    from launcher.run.ready.gate import ReadyGate
    from launcher.run.reload import Reloader
    from launcher.run.stacks.stacks import Stacks
    from launcher.run.watching import Watching


class Detached(Record):
    """What became of a run: (process, host) that run on, processes of this machine that are
    stopped, and what the launch file will not do any more.
    """

    left: tuple[tuple[str, str], ...]
    stopped: tuple[str, ...]
    dropped: tuple[str, ...]

    @property
    def sentences(self) -> list[str]:
        places = ", ".join(f"{name} ({host})" for name, host in self.left)
        texts = [f"detached; these run on: {places}"]
        if self.stopped:
            texts.append(f"stopped, since they run here: {', '.join(self.stopped)}")
        if self.dropped:
            texts.append(f"not carried out any more: {', '.join(self.dropped)}")
        return texts


class RunControl:
    """One per run; `on_process` is called with each process that is started for the first time.

    `keep` is called with the pid of a helper process that outlives a killed launcher. `env` is that
    of the helper that watches files. `is_script`: a script with a LaunchService runs. `has_hosts`:
    there is a hosts file; `ready`: there are rules about the order of starts.
    """

    def __init__(
        self,
        reactor: Reactor,
        log: RunLog,
        driver: ProcessDriver,
        shutdown: Shutdown,
        core: Core,
        core_driver: CoreDriver,
        *,
        options: Callable[[], RunOptions],
        follow: Callable[[RunOptions], object],
        env: Mapping[str, str],
        is_script: Callable[[], bool],
        processes: Mapping[int, Process],
        housekeeper: Housekeeper,
        log_dir: str | None,
        keep: Callable[[int], None],
        screen: StdoutWriter,
        fleet: Fleet | None = None,
        ready: ReadyGate | None = None,
    ) -> None:
        self.reactor = reactor
        self.log = log
        self.core = core
        self.log_dir = log_dir
        self.keep = keep
        self.screen = screen
        self.has_hosts = fleet is not None
        self.ready = ready
        self._fleet = fleet
        self.process_control = ProcessControl(reactor, driver, log, shutdown)
        self.filters = ScreenFilters(processes.values(), log)
        self.on_process: Callable[[Process], None] = lambda process: None
        self.housekeeper = housekeeper
        self.recorder: FlightRecorder | None = None  # with --record
        self.open_page: Callable[[], WebPage] | None = None  # starts it if it is not running
        self._shutdown = shutdown
        self._core_driver = core_driver
        self._options = options
        self._follow = follow
        self._env = env
        self._is_script = is_script
        self._processes = processes

    @functools.cached_property
    def stacks(self) -> Stacks:
        """Imported with the first request."""
        from launcher.run.stacks.stacks import Stacks

        return Stacks(self.reactor)

    @functools.cached_property
    def responsiveness(self) -> Responsiveness:
        """Imported when somebody looks."""
        from launcher.run.monitor.responsiveness import Responsiveness

        adopt = self.housekeeper.add_helper
        return Responsiveness(self.reactor, self.log, self.stacks, self._processes, adopt)

    @property
    def processes(self) -> list[Process]:
        """All of the launch file, in order of first start."""
        return [one for one in self._processes.values() if not one.is_gone]

    @functools.cached_property
    def reloader(self) -> Reloader:
        """Imported with the first request: most runs have none."""
        from launcher.run.reload import Reloader

        return Reloader(
            self.reactor,
            self.core,
            self._core_driver,
            self.process_control,
            self._shutdown,
            self.log,
            processes=self._processes,
            options=self._options,
            follow=self._follow,
            has_hosts=self.has_hosts,
            is_script=self._is_script,
            ready=lambda: self.ready,
        )

    @functools.cached_property
    def watching(self) -> Watching:
        """Imported with the first request: most runs have none."""
        from launcher.run.watching import Watching

        return Watching(
            self.reactor,
            self.process_control,
            self.reloader,
            self.log,
            processes=lambda: self.processes,
            env=self._env,
            is_stopping=lambda: self._shutdown.has_begun,
            stay=self._stay_while,
            nudge=self._core_driver.nudge,
        )

    def _stay_while(self, condition: Callable[[], bool]) -> None:
        if not self._is_script():  # that decides itself when it ends
            self._core_driver.stay_while(condition)

    def watched_files(self, process: Process) -> list[str] | None:
        """None if they are not watched."""
        return self.watching.files(process) if "watching" in vars(self) else None

    def started(self, process: Process) -> None:
        if "watching" in vars(self):
            self.watching.started(process)

    def changed(self) -> None:
        """The state of a process has."""
        self.process_control.changed()
        if "watching" in vars(self):
            self.watching.changed()

    def sample_of(self, process: Process) -> Sample | None:
        """Its last sample; None if there is none yet, or if it is not running."""
        sample = self.housekeeper.samples.get(process.name)
        if process.child is None or sample is None or sample.pid != process.child.pid:
            return None
        return sample

    @functools.cached_property
    def logger_levels(self) -> LoggerLevels:
        """Imported with the first request."""
        from launcher.run.helpers.logger_levels import LoggerLevels

        return LoggerLevels(self.reactor)

    def close(self) -> None:
        if "logger_levels" in vars(self):
            self.logger_levels.close()
        if "responsiveness" in vars(self):
            self.responsiveness.close()
        if "stacks" in vars(self):
            self.stacks.close()
        if "watching" in vars(self):
            self.watching.close()

    def adopt(self, process: Process) -> None:
        self.filters.adopt(process)
        self.on_process(process)

    def detach(self) -> Detached:
        """End the run here, and leave the processes on other hosts to them; LauncherError."""
        left = [] if self._fleet is None else self._fleet.detach()
        if not left:
            raise LauncherError("no process runs on another host")
        self.log.note(Asked("detach"))
        here = [one for one in self.processes if one.is_awaited]
        detached = Detached(
            left=tuple((one.name, _place(one)) for one in left),
            stopped=tuple(one.name for one in here),
            dropped=tuple(self.core.intentions()),
        )
        for text in detached.sentences:
            self.log.log("INFO", "launch", text)
        self._shutdown.stop("detached")
        return detached

    def quit(self, reason: str) -> None:
        self.log.note(Asked("quit"))
        self._shutdown.stop(reason)


def _place(process: Process) -> str:
    host = process.host
    is_away = host is not None and host.unreachable_s is not None
    return f"{process.host_name}, unreachable" if is_away else process.host_name
