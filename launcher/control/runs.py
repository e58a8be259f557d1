"""Runs: those of ours that are going on, and which one a person means."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from launcher.control import folder
from launcher.control.client import (
    HELLO_PATIENCE_S,
    Connection,
    NoRunError,
    SilentError,
    connect,
)
from launcher.control.folder import ControlError
from launcher.engine.cleanup.sweep import RUN_ID_VARIABLE
from launcher.model.record import Record

LOOK_S = 0.02
HALTED_PATIENCE_S = 0.2  # for the first word of a launcher that stands still
_HALTED = ("T", "t")
_ENDED = ("", "Z", "X")
LAUNCH_SUFFIXES = (".launch.py", ".launch.xml", ".launch.yaml", ".launch.yml")
Say = Callable[[str], None]


class Run(Record):
    """A run that answers: what it says of itself, and where its socket is."""

    run_id: str
    pid: int
    target: str
    arguments: tuple[str, ...]
    started: float
    log_dir: str | None
    domain_id: int | None
    processes: tuple[str, ...]
    launcher: str
    protocol: int
    path: Path

    @classmethod
    def of(cls, hello: dict[str, Any], path: Path) -> Run:
        """The run behind a connection."""
        run = hello["run"]
        return cls(
            run_id=run["id"],
            pid=run["pid"],
            target=run["target"],
            arguments=tuple(run["arguments"]),
            started=run["started"],
            log_dir=run["log_dir"],
            domain_id=run["domain_id"],
            processes=tuple(run["processes"]),
            launcher=hello["launcher"],
            protocol=hello["protocol"],
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
        """Talk to it; ControlError."""
        return connect(self.path)


class SilentRun(Record):
    """A run that is there but does not answer; `state` is that of its launcher in /proc."""

    run_id: str
    pid: int
    state: str
    path: Path

    @classmethod
    def at(cls, path: Path) -> SilentRun:
        """The run that should listen at this socket."""
        pid = pid_of(path)
        return cls(path.stem, pid, _state(pid), path)

    @property
    def problem(self) -> str:
        """Why it does not answer, as far as that can be seen."""
        why = f" (it is stopped: state {self.state})" if self.state in _HALTED else ""
        return f"does not answer{why}"

    def error(self) -> SilentError:
        """What to tell somebody who means this one."""
        hint = f"kill -CONT {self.pid}" if self.state in _HALTED else f"kill -9 {self.pid} ends it"
        text = f"run {self.run_id} (pid {self.pid}) is there but {self.problem}"
        return SilentError(text, hint=hint)


def pid_of(path: Path) -> int:
    """The pid of the launcher whose socket this is; 0 if the name has none."""
    pid = path.stem.partition("-")[0]
    return int(pid) if pid.isdecimal() else 0


def _state(pid: int) -> str:
    """`S`, `T` and so on; empty if it is gone."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
    return text[text.rindex(")") + 2 :][:1]


AnyRun = Run | SilentRun


def _silent(text: str) -> None:
    """Nobody wants to hear it."""


def live_runs(say: Say = _silent) -> list[Run]:
    """Those that answer, the oldest first; `say` is told of the others, as by `all_runs`."""
    runs = []
    for run in all_runs(say):
        if isinstance(run, Run):
            runs.append(run)
        else:
            say(f"run {run.run_id} (pid {run.pid}) {run.problem}")
    return runs


def all_runs(say: Say = _silent) -> list[AnyRun]:
    """Those that are going on, the oldest first.

    The sockets of launchers that were killed are removed, and `say` is told so.
    """
    runs: list[AnyRun] = []
    removed: list[str] = []
    for path in folder.sockets(os.environ, os.getuid()):
        try:
            is_halted = _state(pid_of(path)) in _HALTED
            patience_s = HALTED_PATIENCE_S if is_halted else HELLO_PATIENCE_S
            with connect(path, patience_s=patience_s) as connection:
                runs.append(Run.of(connection.hello, path))
        except NoRunError:
            with contextlib.suppress(FileNotFoundError):
                path.unlink()
                removed.append(path.stem)
        except SilentError:
            runs.append(SilentRun.at(path))
        except (ControlError, KeyError, TypeError) as error:
            say(f"{path}: {error}")
    if len(removed) == 1:
        say(f"removed the socket of a run that was killed: {removed[0]}")
    elif removed:
        say(f"removed the sockets of {len(removed)} runs that were killed")
    return runs


def find_run(which: str | None = None, say: Say = _silent, *, looks: bool = False) -> Run:
    """The run that is meant: by its id, its pid or its target, of each the beginning is enough.

    None stands for the only one, or the one that we are a part of; one in another folder than
    ours counts as that only for who `looks` and changes nothing. ControlError in words where
    there is none, are several, or it does not answer.
    """
    runs = all_runs(say)
    if not runs:
        hint = "python -m launcher TARGET starts one (not with --no-control)"
        raise ControlError("no run of yours is going on", hint=hint)
    found = _ours(runs, looks=looks) if which is None else _matching(runs, which)
    if len(found) == 1:
        (run,) = found
        if isinstance(run, SilentRun):
            raise run.error()
        return run
    listed = "\n".join(f"  {_described(run)}" for run in (found or runs))
    if which is None and not found:
        here = folder.preferred(os.environ, os.getuid())
        text = f"no run of yours is going on in {here}"
        raise ControlError(text, hint=f"elsewhere there are; pick one with --run ID:\n{listed}")
    if not found:
        raise ControlError(f"there is no run '{which}'", hint=f"these are going on:\n{listed}")
    what = "several runs are going on" if which is None else f"'{which}' may be several runs"
    raise ControlError(what, hint=f"pick one with --run ID:\n{listed}")


def _ours(runs: Sequence[AnyRun], *, looks: bool) -> list[AnyRun]:
    """The one that we were started by, if it is among them; else those of our folder."""
    ours = [run for run in runs if run.run_id == os.environ.get(RUN_ID_VARIABLE)]
    if ours:
        return ours
    here = folder.preferred(os.environ, os.getuid())
    near = [run for run in runs if run.path.parent == here]
    return near or (list(runs) if looks else [])


def _matching(runs: Sequence[AnyRun], which: str) -> list[AnyRun]:
    exact = [run for run in runs if which in (run.run_id, str(run.pid))]
    return exact or [run for run in runs if _begins(run, which)]


def _begins(run: AnyRun, which: str) -> bool:
    names = [run.run_id]
    if isinstance(run, Run):
        names += [run.target, os.path.basename(run.target)]
    return any(name.startswith(which) for name in names)


def _described(run: AnyRun) -> str:
    if isinstance(run, SilentRun):
        return f"{run.run_id}  {run.problem}"
    since = time.strftime("%H:%M:%S", time.localtime(run.started))
    words = " ".join([run.short_target, *run.arguments])
    return f"{run.run_id}  {words}  (since {since}, {len(run.processes)} processes)"


def wait_for_run(pid: int, timeout_s: float) -> Run:
    """The run whose launcher is the process `pid`, as soon as it listens.

    ControlError if that process has ended, or does not listen within `timeout_s`.
    """
    deadline = time.monotonic() + timeout_s
    while True:
        if _state(pid) in _ENDED:
            raise ControlError(f"process {pid} has ended")
        for path in folder.sockets(os.environ, os.getuid()):
            if path.stem.startswith(f"{pid}-"):
                with contextlib.suppress(NoRunError), connect(path) as connection:
                    return Run.of(connection.hello, path)
        if time.monotonic() >= deadline:
            raise ControlError(f"process {pid} has opened no run within {timeout_s:g} s")
        time.sleep(LOOK_S)
