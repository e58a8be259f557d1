"""Runs: those of ours that are going on, and which one a person means."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from launcher.control import folder
from launcher.control.client import Connection, NoRunError, SilentError, connect
from launcher.control.folder import ControlError
from launcher.engine.sweep import RUN_ID_VARIABLE
from launcher.model.record import Record

LOOK_S = 0.02
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


def _silent(text: str) -> None:
    """Nobody wants to hear it."""


def live_runs(say: Say = _silent) -> list[Run]:
    """Those that answer, the oldest first.

    The sockets of launchers that were killed are removed, and `say` is told so, as it is of those
    that do not answer.
    """
    runs = []
    for path in folder.sockets(os.environ, os.getuid()):
        try:
            with connect(path) as connection:
                runs.append(Run.of(connection.hello, path))
        except NoRunError:
            with contextlib.suppress(FileNotFoundError):
                path.unlink()
                say(f"removed the socket of a run that was killed: {path.stem}")
        except SilentError:
            say(f"run {path.stem} does not answer")
        except (ControlError, KeyError, TypeError) as error:
            say(f"{path}: {error}")
    return runs


def find_run(which: str | None = None, say: Say = _silent) -> Run:
    """The run that is meant: by its id, its pid or its target, of each the beginning is enough.

    None stands for the only one, or the one that we are a part of. ControlError in words where
    there is none, or are several.
    """
    runs = live_runs(say)
    if not runs:
        hint = "python -m launcher TARGET starts one (not with --no-control)"
        raise ControlError("no run of yours is going on", hint=hint)
    found = _ours(runs) if which is None else _matching(runs, which)
    if len(found) == 1:
        return found[0]
    listed = "\n".join(f"  {_described(run)}" for run in (found or runs))
    if not found:
        raise ControlError(f"there is no run '{which}'", hint=f"these are going on:\n{listed}")
    what = "several runs are going on" if which is None else f"'{which}' may be several runs"
    raise ControlError(what, hint=f"pick one with --run ID:\n{listed}")


def _ours(runs: Sequence[Run]) -> Sequence[Run]:
    """The one that we were started by, if it is among them; else all."""
    return [run for run in runs if run.run_id == os.environ.get(RUN_ID_VARIABLE)] or runs


def _matching(runs: Sequence[Run], which: str) -> list[Run]:
    exact = [run for run in runs if which in (run.run_id, str(run.pid))]
    if exact:
        return exact
    return [
        run
        for run in runs
        if run.run_id.startswith(which)
        or run.target.startswith(which)
        or os.path.basename(run.target).startswith(which)
    ]


def _described(run: Run) -> str:
    since = time.strftime("%H:%M:%S", time.localtime(run.started))
    words = " ".join([run.short_target, *run.arguments])
    return f"{run.run_id}  {words}  (since {since}, {len(run.processes)} processes)"


def wait_for_run(pid: int, timeout_s: float) -> Run:
    """The run whose launcher is the process `pid`, as soon as it listens; ControlError.

    Who waits for the parent does not wait any longer than that lives.
    """
    deadline = time.monotonic() + timeout_s
    is_ours = os.getppid() == pid
    while True:
        if is_ours and os.getppid() != pid:
            raise ControlError(f"process {pid} has ended")
        for path in folder.sockets(os.environ, os.getuid()):
            if path.stem.startswith(f"{pid}-"):
                with contextlib.suppress(NoRunError), connect(path) as connection:
                    return Run.of(connection.hello, path)
        if time.monotonic() >= deadline:
            raise ControlError(f"process {pid} has opened no run within {timeout_s:g} s")
        time.sleep(LOOK_S)
