"""Lists the active runs of this user, and finds one by id, pid or target."""

from __future__ import annotations

import contextlib
import fnmatch
import os
import re
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from launcher.base.model.record import Record
from launcher.base.model.run_options import program_of
from launcher.base.program import program
from launcher.base.text import count
from launcher.control.client import (
    HELLO_TIMEOUT_S,
    Connection,
    NoRunError,
    SilentError,
)
from launcher.control.protocol import VERSION
from launcher.output.logs.run_directory import EVENTS, MERGED, PLAN, current_root
from launcher.posix import proc, socket_directory
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.socket_directory import ControlError

POLL_S = 0.02
SUSPENDED_TIMEOUT_S = 0.2  # for the first line of a suspended launcher
_SUSPENDED = ("T", "t")
LAUNCH_SUFFIXES = (".launch.py", ".launch.xml", ".launch.yaml", ".launch.yml")
Report = Callable[[str], None]


class ListedRun(Record):
    """A run that answers; `path` is its socket."""

    run_id: str
    pid: int
    target: str
    arguments: tuple[str, ...]
    started_wall_s: float
    log_dir: str | None
    domain_id: int | None
    processes: tuple[str, ...]
    path: Path

    @classmethod
    def of(cls, hello: dict[str, Any], path: Path) -> ListedRun:
        protocol = hello.get("protocol")
        if protocol != VERSION:
            text = f"it has protocol {protocol}, this launcher {VERSION}"
            raise ControlError(text, hint="use the launcher that started the run")
        run = hello["run"]
        return cls(
            run_id=run["id"],
            pid=run["pid"],
            target=run["target"],
            arguments=tuple(run["arguments"]),
            started_wall_s=run["started_wall_s"],
            log_dir=run["log_dir"],
            domain_id=run["domain_id"],
            processes=tuple(run["processes"]),
            path=path,
        )

    @property
    def short_target(self) -> str:
        """`system` for `/home/me/launch/system.launch.py`."""
        name = os.path.basename(self.target)
        for suffix in LAUNCH_SUFFIXES:
            name = name.removesuffix(suffix)
        return name

    def connect(self) -> Connection:
        """Raises ControlError."""
        return Connection(self.path)


class SilentRun(Record):
    """A run that does not answer; `state` is that of its launcher in /proc."""

    run_id: str
    pid: int
    state: str
    path: Path

    @classmethod
    def at(cls, path: Path) -> SilentRun:
        pid = pid_of(path)
        return cls(path.stem, pid, proc.state(pid), path)

    @property
    def problem(self) -> str:
        why = f" (suspended: state {self.state})" if self.state in _SUSPENDED else ""
        return f"does not answer{why}"

    def error(self) -> SilentError:
        """The error for a request to this run."""
        is_suspended = self.state in _SUSPENDED
        hint = f"kill -CONT {self.pid}" if is_suspended else f"kill -9 {self.pid} ends it"
        text = f"run {self.run_id} (pid {self.pid}) {self.problem}"
        return SilentError(text, hint=hint)


def pid_of(path: Path) -> int:
    """The pid of the launcher whose socket this is; 0 if the name has none."""
    pid = path.stem.partition("-")[0]
    return int(pid) if pid.isdecimal() else 0


AnyRun = ListedRun | SilentRun


def all_runs(report: Report = lambda text: None) -> list[AnyRun]:
    """All runs, the oldest first; `report` gets notes for users.

    Removes the sockets of launchers that were killed.
    """
    runs: list[AnyRun] = []
    removed: list[str] = []
    for path in socket_directory.sockets(os.environ, os.getuid()):
        try:
            is_suspended = proc.is_suspended(pid_of(path))
            timeout_s = SUSPENDED_TIMEOUT_S if is_suspended else HELLO_TIMEOUT_S
            with Connection(path, timeout_s=timeout_s) as connection:
                runs.append(ListedRun.of(connection.hello, path))
        except NoRunError:
            with contextlib.suppress(FileNotFoundError):
                path.unlink()
                removed.append(path.stem)
        except SilentError:
            runs.append(SilentRun.at(path))
        except (ControlError, KeyError, TypeError) as error:
            text = str(error)
            report(text if text.startswith(f"{path}: ") else f"{path}: {text}")
    if len(removed) == 1:
        report(f"removed the socket of a run that was killed: {removed[0]}")
    elif removed:
        report(f"removed the sockets of {len(removed)} runs that were killed")
    return runs


class NoActiveRunError(ControlError):
    """There is no run at all."""


# What a verb shows of an active run is in this file afterwards.
_FILES = {"logs": MERGED, "events": EVENTS, "plan": PLAN}
# Not that of a process, whose name ends with its number.
_MERGED_NAME = re.compile(r"^(?!.*-\d+(-stdout|-stderr)?\.log$).*\.log$")


def files_of_last_run(verb: str, names: Sequence[str] = ()) -> list[str]:
    """Paths of the files of the last run that have what this verb shows; `names` are processes."""
    folder = os.path.realpath(os.path.join(current_root(os.environ), "latest"))
    if verb not in _FILES or not os.path.isfile(f"{folder}/{EVENTS}"):
        return []
    files = sorted(os.listdir(folder))
    own = [name for name in files if _is_log_of(name, names)]
    if not own and verb == "logs" and MERGED not in files:  # `--log-file-name`
        own = [name for name in files if _MERGED_NAME.match(name)]
    return [f"{folder}/{name}" for name in own or [_FILES[verb]]]


def _is_log_of(file: str, names: Sequence[str]) -> bool:
    name = file.removesuffix(".log")
    label = name.rpartition("-")[0]
    return file != name and any(
        fnmatch.fnmatchcase(one, name_of.rpartition("/")[2])
        for one in (name, label, *program_of(label))
        for name_of in names
    )


def find_run(
    which: str | None = None, report: Report = lambda text: None, *, read_only: bool = False
) -> ListedRun:
    """The run whose id, pid or target is or starts with `which`.

    None: the run that this process belongs to, else the only run in the socket directory of this
    shell; for a `read_only` caller, the only run in any of them. Raises ControlError if
    there is no such run, if there are several, or if it does not answer.
    """
    runs = all_runs(report)
    if not runs:
        hint = f"start one with `{program()} TARGET` (without --no-control)"
        raise NoActiveRunError("no active run", hint=hint)
    found = _ours(runs, read_only=read_only) if which is None else _matching(runs, which)
    if len(found) == 1:
        (run,) = found
        if isinstance(run, SilentRun):
            raise run.error()
        return run
    listed = "\n".join(f"  {_described(run)}" for run in (found or runs))
    if which is None and not found:
        text = f"no active run in {socket_directory.preferred(os.environ, os.getuid())}"
        raise ControlError(text, hint=f"choose a run elsewhere with --run ID:\n{listed}")
    if not found:
        raise ControlError(f"unknown run '{which}'", hint=f"active runs:\n{listed}")
    what = "several runs are active" if which is None else f"'{which}' matches several runs"
    raise ControlError(what, hint=f"choose one with --run ID:\n{listed}")


def _ours(runs: Sequence[AnyRun], *, read_only: bool) -> list[AnyRun]:
    """The run that this process belongs to, else those in the socket directory of this shell."""
    ours = [run for run in runs if run.run_id == os.environ.get(RUN_ID_VARIABLE)]
    if ours:
        return ours
    here = socket_directory.preferred(os.environ, os.getuid())
    near = [run for run in runs if run.path.parent == here]
    return near or (list(runs) if read_only else [])


def _matching(runs: Sequence[AnyRun], which: str) -> list[AnyRun]:
    exact = [run for run in runs if which in (run.run_id, str(run.pid))]
    return exact or [run for run in runs if _begins(run, which)]


def _begins(run: AnyRun, which: str) -> bool:
    names = [run.run_id]
    if isinstance(run, ListedRun):
        names += [run.target, os.path.basename(run.target)]
    return any(name.startswith(which) for name in names)


def _described(run: AnyRun) -> str:
    if isinstance(run, SilentRun):
        return f"{run.run_id}  {run.problem}"
    since = time.strftime("%H:%M:%S", time.localtime(run.started_wall_s))
    words = " ".join([run.short_target, *run.arguments])
    return f"{run.run_id}  {words}  (since {since}, {count(len(run.processes), 'process')})"


def wait_for_run(pid: int, timeout_s: float) -> ListedRun:
    """Wait until the launcher `pid` listens; ControlError if it ends, or at the timeout."""
    deadline = time.monotonic() + timeout_s
    while True:
        if not proc.is_alive(pid):
            raise ControlError(f"process {pid} has ended")
        for path in socket_directory.sockets(os.environ, os.getuid()):
            if path.stem.startswith(f"{pid}-"):
                with contextlib.suppress(NoRunError), Connection(path) as connection:
                    return ListedRun.of(connection.hello, path)
        if time.monotonic() >= deadline:
            raise ControlError(f"process {pid} opened no control socket within {timeout_s:g} s")
        time.sleep(POLL_S)
