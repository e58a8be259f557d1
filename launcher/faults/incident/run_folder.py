"""The log folder of a run that lives or is over, by its id, pid, target or folder."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from launcher.base.model.event_entries import entry_in
from launcher.base.model.run_event import Entry
from launcher.base.text import several
from launcher.control.active_runs import LAUNCH_SUFFIXES, ListedRun, all_runs, find_run
from launcher.faults.history import database
from launcher.faults.history.database import HistoryError
from launcher.faults.incident.document import IncidentError
from launcher.output.logs import old_runs
from launcher.output.logs.run_directory import EVENTS, current_root
from launcher.posix import socket_directory
from launcher.posix.socket_directory import ControlError

Report = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class RunFolder:
    """A folder with the files of a run; `run` and `versions` as incidents have them."""

    path: str
    run: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return os.path.basename(self.path)

    def file(self, *names: str) -> str:
        return os.path.join(self.path, *names)


def entries_of(folder: str) -> list[Entry]:
    """The event log in this folder; [] if it cannot be read."""
    try:
        with open(os.path.join(folder, EVENTS), "rb") as file:
            return [*filter(None, map(entry_in, file))]
    except OSError:
        return []


def find(which: str | None, report: Report) -> RunFolder:
    """The run that `which` names, without it the newest; IncidentError, ControlError."""
    if which is not None and os.path.isdir(which):
        return _opened(os.path.realpath(which))
    active = [run for run in all_runs(report) if isinstance(run, ListedRun)]
    if which is None:
        return _newest(active)
    with contextlib.suppress(ControlError):
        return _of_active(find_run(which, read_only=True))
    return _over(which)


def _opened(path: str) -> RunFolder:
    """A folder that a user has named."""
    if os.path.isfile(os.path.join(path, EVENTS)):
        return _known(path)
    hint = f"the folder of a run has a file {EVENTS}"
    newest = os.path.join(path, "latest")
    if os.path.isfile(os.path.join(newest, EVENTS)):
        hint = f"its newest run: {os.path.realpath(newest)}"
    raise IncidentError(f"{path} is not the folder of a run", hint=hint)


def _newest(active: list[ListedRun]) -> RunFolder:
    """Of the active runs of this shell and the last one; names of folders begin with its time."""
    here = socket_directory.preferred(os.environ, os.getuid())
    near = [run for run in active if run.path.parent == here and run.log_dir]
    found = {os.path.basename(run.log_dir or ""): _of_active(run) for run in near}
    latest = os.path.realpath(os.path.join(current_root(os.environ), "latest"))
    if os.path.isfile(os.path.join(latest, EVENTS)):
        found.setdefault(os.path.basename(latest), _known(latest))
    if not found:
        hint = "name the log folder of a run: --run FOLDER"
        raise IncidentError(f"there is no run in {current_root(os.environ)}", hint=hint)
    return found[max(found)]


def _of_active(run: ListedRun) -> RunFolder:
    if run.log_dir is None:
        raise IncidentError(f"run {run.run_id} has no log files", hint="it has --no-log-files")
    known = {
        "id": run.run_id,
        "pid": run.pid,
        "target": run.target,
        "arguments": list(run.arguments),
        "started_wall_s": run.started_wall_s,
        "log_dir": run.log_dir,
        "domain_id": run.domain_id,
    }
    return RunFolder(run.log_dir, known, _known(run.log_dir).versions)


def _over(which: str) -> RunFolder:
    """The newest run that has this id, pid or target, or whose folder begins with the word."""
    root = current_root(os.environ)
    try:
        names = old_runs.runs(root)
    except OSError as error:
        raise IncidentError(f"cannot read {root}: {error.strerror}") from None
    history = {os.path.basename(one["log_dir"]): one for one in _history(root)}
    for name in reversed(names):
        row = history.get(name, {})
        if _fits(which, name, row):
            return _known(os.path.join(root, name))
    known = several(reversed(names), 3) or "none"
    raise IncidentError(f"unknown run '{which}'", hint=f"runs in {root}, the newest first: {known}")


def _fits(which: str, name: str, row: Mapping[str, Any]) -> bool:
    pid = name.rpartition("-")[2]
    if which == pid or which.partition("-")[0] == pid or name.startswith(which):
        return True
    run_id, target = str(row.get("id") or ""), str(row.get("target") or "")
    file = os.path.basename(target)
    names = [run_id, target, file, *(file.removesuffix(one) for one in LAUNCH_SUFFIXES)]
    return any(one.startswith(which) for one in names)


def _known(path: str) -> RunFolder:
    """With what the history has about the run."""
    row: Mapping[str, Any] = next(
        (one for one in _history(os.path.dirname(path)) if one["log_dir"] == path), {}
    )
    run = {"id": row.get("id"), "target": row.get("target"), "started_wall_s": row.get("started_s")}
    versions = {key: row.get(key) for key in ("launcher", "git")}
    versions["hash"] = row.get("files_hash")
    return RunFolder(
        path,
        {**{key: one for key, one in run.items() if one is not None}, "log_dir": path},
        {key: one for key, one in versions.items() if one is not None},
    )


def _history(root: str) -> list[dict[str, Any]]:
    """The table `runs`; empty where there is none, or it cannot be read."""
    path = database.path_in(root)
    if not os.path.isfile(path):
        return []
    try:
        with database.reading(path) as opened:
            rows = [dict(row) for row in opened.execute("SELECT * FROM runs ORDER BY started_s")]
    except HistoryError:
        return []
    return [row for row in rows if isinstance(row.get("log_dir"), str)]
