"""Shows the history of faults: `faults --all-runs`."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Mapping, Sequence

from launcher.base.errors import LauncherError
from launcher.base.text import aligned, count, did_you_mean, escape
from launcher.faults.history.database import HistoryError
from launcher.faults.history.reading import FaultSummary, TargetHistory, histories
from launcher.output.logs.run_directory import current_root
from launcher.posix.json_output import print_document
from launcher.posix.stdio import print_text

_HEAD = ("FAULT", "SINCE", "LAST", "TIMES", "RUNS", "SINCE VERSION", "LAST VERSION", "LAST CAUSE")
_RIGHT = (3,)
MAX_NAME = 80


def show(env: Mapping[str, str], target: str | None = None, *, as_json: bool = False) -> int:
    """Print the faults of all runs, of all targets or of one, and return the exit code.

    `target` is a launch file, its path, or the beginning of its name. LauncherError if there are
    no runs of it, or the history cannot be read.
    """
    try:
        found = histories(current_root(env))
    except HistoryError as error:
        raise LauncherError(str(error), hint="remove it to begin a new one") from None
    if target is not None:
        found = _chosen(found, target)
    if as_json:
        print_document({"targets": [one.document() for one in found]})
    elif found:
        print_text("\n\n".join("\n".join(_lines(one)) for one in found))
    else:
        print_text("no run was watched; `--watchful` does it")
    return 0


def _chosen(found: Sequence[TargetHistory], word: str) -> list[TargetHistory]:
    path = os.path.abspath(word)
    exact = [one for one in found if one.target in (word, path)]
    named = [one for one in found if os.path.basename(one.target).startswith(word)]
    if exact or named:
        return exact or named
    names = {os.path.basename(one.target) for one in found}
    hint = did_you_mean(word, names) or "`faults --all-runs` shows all"
    raise LauncherError(f"no run of '{word}' was watched", hint=hint)


def _lines(one: TargetHistory) -> Iterator[str]:
    since = f"{count(one.runs, 'run')} since {_clock(one.since_s)}"
    yield f"{escape(one.target, keep='')}: {since}{'' if one.faults else ', no fault'}"
    if one.faults:
        rows = [_HEAD, *(_cells(fault, one.runs) for fault in one.faults)]
        yield from (line.rstrip() for line in aligned(rows, _RIGHT))


def _cells(fault: FaultSummary, runs: int) -> tuple[str, ...]:
    without = f", not in the last {fault.runs_since}" if fault.runs_since else ""
    mute = ", muted" if fault.muted else ""
    cells = (
        f"{fault.fault[:MAX_NAME]}{mute}",
        _clock(fault.since_s),
        _clock(fault.last_s),
        str(fault.times),
        f"{fault.runs} of {runs}{without}",
        str(fault.first_version),
        "the same" if fault.last_version == fault.first_version else str(fault.last_version),
        fault.cause or "-",
    )
    return tuple(escape(cell, keep="") for cell in cells)


def _clock(wall_s: float) -> str:
    try:
        return time.strftime("%Y-%m-%d %H:%M", time.localtime(wall_s))
    except (OverflowError, ValueError, OSError):  # a hostile database
        return "?"
