"""Restarts processes whose files have changed, and reloads a launch file that has."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence

from launcher.base.errors import LauncherError
from launcher.base.model.ros_arguments import PARAMETER_FILE, ros_options
from launcher.base.model.run_events import FilesChanged
from launcher.base.model.spec import ProcessSpec
from launcher.base.text import count, how_it_ended
from launcher.packages.extras import require
from launcher.posix.reactor import Reactor, Timer
from launcher.run.helpers.json_lines import JsonLinesProcess, own_end
from launcher.run.part import Part
from launcher.run.processes.machine_events import ProcessState
from launcher.run.processes.process import Process
from launcher.run.reload.reload import Change, ComparedProcess, Reloader, restart_changed
from launcher.run.requests.request_result import Kind, Result

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.run import Run


MAX_STARTS = 4  # of the process that watches; then the run continues without one
RESTART_DELAY_S = 0.5
_ENVIRONMENT = ("PATH", "PYTHONPATH")  # what decides which files a program loads
_NAMED = 3  # files in a message
# The kernel stamps files with the time of its last tick, and a start is reported after it.
_EARLIER_NS = 20_000_000


class Watching(Part):
    """It is off until it is turned on; `launch_files` are what the launch file has read, if that
    is watched.
    """

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._reactor = run.reactor
        self._log = run.log
        self._watcher: FileWatcher | None = None
        self._is_general = False  # for every process, and the launch file
        self._chosen: dict[int, bool] = {}  # of a process, other than in general
        self._files: dict[str, list[str]] = {}
        self._loads_again = False
        self._has_said_idle = False
        self.launch_files: list[str] = []

    def begin(self) -> None:
        if not self._is_stopping():
            self.turn(None, on=True)

    def _is_stopping(self) -> bool:
        return self.run.shutdown.has_begun

    @property
    def _reloader(self) -> Reloader:
        return self.run.parts.need(Reloader)

    # ---- on and off

    @property
    def is_on(self) -> bool:
        return self._is_general or any(self._chosen.values())

    def watches(self, process: Process) -> bool:
        return process.host is None and self._chosen.get(process.process_id, self._is_general)

    def files(self, process: Process) -> list[str] | None:
        """What is watched for it; None if it is not, or not known yet."""
        return self._files.get(process.name) if self.watches(process) else None

    def turn(self, processes: Sequence[Process] | None, *, on: bool) -> None:
        """Watch these, or not; None: all, and the launch file. UsageError without watchfiles."""
        if on:
            require("watch", "watchfiles", "watching files")
        if processes is None:
            self._is_general = on
            self._chosen.clear()
        else:
            self._chosen.update({one.process_id: on for one in processes})
        if not self.is_on:
            self.end_helpers()
            self.run.core_driver.nudge()  # the run may have gone on only for this
        elif self._watcher is None:
            self.run.stay_while(lambda: self.is_on and not self._is_stopping())
            self._watcher = FileWatcher(
                self._reactor,
                self.run.env,
                self._log.warn,
                on_start=self._send_all,
                on_message=self._received,
            )
            self._watcher.start()
        else:
            self._send_all()

    def end_helpers(self) -> None:
        if self._watcher is not None:
            self._watcher.close()
            self._watcher = None
        self._files.clear()
        self.launch_files = []

    # ---- messages to the watcher

    def _send_all(self) -> None:
        for process in self.run.processes:
            if self.watches(process):
                self._send_process(process)
            elif self._files.pop(process.name, None) is not None:
                self._send({"forget": process.name})
        self._send_launch(self._reactor.now())

    def _send(self, message: Mapping[str, object]) -> None:
        if self._watcher is not None:
            self._watcher.send(message)

    def started(self, process: Process) -> None:
        self._has_said_idle = False
        if self.watches(process):
            self._send_process(process)

    def _send_process(self, process: Process) -> None:
        spec, began_s = process.spec, process.machine.running_since
        self._send(
            {
                "process": process.name,
                "argv": spec.argv,
                "members": [one.argv for one in spec.members],
                "env": {name: spec.env[name] for name in _ENVIRONMENT if name in spec.env},
                "cwd": spec.cwd,
                "parameters": _parameter_files(spec),
                "started_ns": self._wall_ns(self._reactor.now() if began_s is None else began_s),
            }
        )

    def _wall_ns(self, when_s: float) -> int:
        return time.time_ns() - int((self._reactor.now() - when_s) * 1e9) - _EARLIER_NS

    def _send_launch(self, evaluated_s: float) -> None:
        if not self._is_general:
            self.launch_files = []
            self._send({"forget": ""})
            return
        try:
            paths = self._reloader.core.launch_files()
        except LauncherError:
            return  # it cannot be reloaded
        self.launch_files = [path for path in paths if os.path.exists(path)]
        self._send({"launch": paths, "started_ns": self._wall_ns(evaluated_s)})

    # ---- messages of the watcher

    def _received(self, message: Mapping[str, Any]) -> None:
        match message:
            case {"files": name, "paths": paths}:
                self._files[name] = paths
            case {"changed": paths, "processes": processes, "launch": has_launch}:
                self._changed(paths, processes, has_launch=has_launch)
            case {"broken": text, "processes": names}:
                self._log.log("ERROR", "launch", f"{text}\n{_run_on(names)}")
            case {"deleted": path, "processes": names}:
                text = f"{os.path.basename(path)} was deleted: {_run_on(names)}"
                self._log.log("WARNING", "launch", text)
            case {"warning": text}:
                self._log.warn(text)

    def _changed(
        self, paths: Sequence[str], changed: Mapping[str, int], *, has_launch: bool
    ) -> None:
        if self._is_stopping():
            return
        due = [one for one in self.run.processes if self._is_due(one, changed.get(one.name))]
        chosen = [one for one in due if not one.is_debugged]
        names = [one.name for one in chosen]
        if debugged := [one.name for one in due if one.is_debugged]:
            text = f"{_named(paths)} changed: {_run_on(debugged)}, under a debugger"
            self._log.log("INFO", "launch", text)
        self._log.note(FilesChanged(tuple(paths), tuple(names)))
        if names or has_launch:
            parts = [f"{', '.join(names)} restart{'s' * (len(names) == 1)}"] if names else []
            parts += ["the launch file is evaluated again"] if has_launch else []
            self._log.log("INFO", "launch", f"{_named(paths)} changed: {', and '.join(parts)}")
        steered = [one for one in chosen if self._is_steered(one)]
        if has_launch or steered:
            self._reload(steered)
        for process in chosen:
            if process.is_gone or process.is_debugged:
                continue
            if self._is_due(process, changed.get(process.name)):
                restart_changed(self.run.process_control, process, _ignore)

    def _is_due(self, process: Process, changed_ns: int | None) -> bool:
        """Whether it has loaded what was there before, and no user has stopped it."""
        machine = process.machine
        if changed_ns is None or not self.watches(process):
            return False
        if machine.state in (ProcessState.STOPPED, ProcessState.STOPPING, ProcessState.STARTING):
            return machine.state is ProcessState.STARTING and process.child is not None
        began_s = machine.running_since
        return began_s is None or changed_ns > self._wall_ns(began_s)

    def _is_steered(self, process: Process) -> bool:
        """Whether its restart is to be followed by what the launch file asks of its node."""
        try:
            return self._reloader.core.is_steered(process.spec)
        except LauncherError:
            return False

    def _reload(self, edited: Sequence[Process] = ()) -> None:
        if self._reloader.is_busy:
            self._loads_again = True
            return
        began_s = self._reactor.now()
        try:
            self._reloader.reload(self._reloaded, edited)
        except LauncherError as error:
            text = f"{error.render()}\nthe launch file was not reloaded: everything runs on"
            self._log.log("ERROR", "launch", text)
        else:
            self._send_launch(began_s)

    def _reloaded(self, entries: Sequence[ComparedProcess]) -> None:
        self._log.log("INFO", "launch", _summary(entries))
        for one in entries:
            if one.change is Change.GONE and self._files.pop(one.name, None) is not None:
                self._send({"forget": one.name})
        if self._loads_again:
            self._loads_again = False
            self._reload()

    # ---- the run

    def info(self, process: Process) -> dict[str, object]:
        watched = self.files(process)
        return {"watched_files": None if watched is None else len(watched)}

    def changed(self) -> None:
        """Say why the run goes on if it was the last process."""
        processes = self.run.processes
        if not self.is_on or self._has_said_idle or self._is_stopping():
            return
        if processes and not any(one.machine.is_pending or one.is_replaced for one in processes):
            self._has_said_idle = True
            text = "no process runs; waiting for changes of files (Ctrl-C ends the run)"
            self._log.log("INFO", "launch", text)


def _ignore(result: Result) -> None:
    """The log has what happened."""


def _parameter_files(spec: ProcessSpec) -> list[str]:
    """Those of the user; the launcher's own are made anew with each evaluation."""
    if spec.members:
        return [path for one in spec.members for path in _parameter_files(one)]
    sources = () if spec.ros is None else spec.ros.parameters
    generated = {one.file for one in sources if one.generated is not None}
    given = [path for option, path in ros_options(spec.argv) if option is PARAMETER_FILE]
    return [path for path in given if path not in generated]


def _run_on(names: Iterable[str]) -> str:
    listed = list(names)
    if len(listed) == 1:
        return f"{listed[0]} runs on with what it has loaded"
    return f"{', '.join(listed)} run on with what they have loaded"


def _named(paths: Sequence[str]) -> str:
    names = list(dict.fromkeys(os.path.basename(path) for path in paths))
    if len(names) <= _NAMED:
        return ", ".join(names)
    return f"{names[0]} and {count(len(names) - 1, 'more file')}"


def _summary(entries: Sequence[ComparedProcess]) -> str:
    groups: dict[str, list[str]] = {}
    for change in _FAILED:
        for one in entries:
            if one.change is change:
                groups.setdefault(_outcome(one), []).append(one.name)
    parts = [f"{outcome}: {', '.join(names)}" for outcome, names in groups.items()]
    return f"the launch file was reloaded: {'; '.join(parts) or 'all processes are the same'}"


_FAILED = {
    Change.NEW: "not started",
    Change.GONE: "not stopped",
    Change.CHANGED: "not restarted",
}


def _outcome(one: ComparedProcess) -> str:
    if one.result is None or one.result.done:
        return one.change.value
    if one.result.kind is Kind.UNDER_DEBUGGER:
        return f"{_FAILED[one.change]}, under a debugger"
    return _FAILED[one.change]


class FileWatcher:
    """The process that watches (launcher.run.watch), restarted if it dies.

    `on_message` gets its messages; `on_start` is called when it needs everything. It ends with
    the launcher, since its input ends then.
    """

    def __init__(
        self,
        reactor: Reactor,
        env: Mapping[str, str],
        warn: Callable[[str], None],
        *,
        on_start: Callable[[], None],
        on_message: Callable[[Mapping[str, Any]], None],
    ) -> None:
        self._reactor = reactor
        self._env = own_end(env)
        self._warn = warn
        self._on_start = on_start
        self._on_message = on_message
        self._process: JsonLinesProcess | None = None
        self._started = 0
        self._timer: Timer | None = None

    @property
    def pid(self) -> int | None:
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        self._timer = None
        self._started += 1
        try:
            self._process = JsonLinesProcess(
                self._reactor,
                "launcher.run.watch",
                self._env,
                on_message=self._on_message,
                on_end=self._ended,
            )
        except OSError as error:
            self._warn(f"files are not watched: {error.strerror}")
            return
        self._on_start()

    def send(self, message: Mapping[str, object]) -> None:
        if self._process is not None:  # else: it gets everything at its start
            self._process.send(message)

    def _ended(self, code: int, line: str) -> None:
        self._process = None
        reason = f": {line}" if line else ""
        is_restarted = self._started < MAX_STARTS
        what = "restarting it" if is_restarted else "files are not watched any more"
        self._warn(f"the file watcher died ({how_it_ended(code)}){reason}; {what}")
        if is_restarted:
            self._timer = self._reactor.call_later(RESTART_DELAY_S, self.start)

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._process is not None:
            self._process.close()  # it has nothing to clean up
            self._process = None
