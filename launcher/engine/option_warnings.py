"""Unmatched: options about processes (`--required NAME`) that no process is meant by.

What stands in a file (`--budgets`) is told by its line there.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Sequence

from launcher.engine.logs.run_log import RunLog
from launcher.model.options import RunOptions, matches
from launcher.model.spec import ProcessSpec


def unmatched(options: RunOptions, specs: Sequence[ProcessSpec]) -> list[tuple[str, str]]:
    """(`--required 'dispacher' fits no process`, the name that may be meant) for each."""
    found = {}
    for place, pattern in _patterns(options):
        if not any(matches(pattern, spec) for spec in specs):
            found[f"{place} '{pattern}'"] = nearest(pattern, specs)
    return [(f"{what} fits no process", meant) for what, meant in found.items()]


def warn_of_unmatched(
    options: RunOptions, specs: Sequence[ProcessSpec], log: RunLog, *, is_over: bool
) -> None:
    """A misspelt name must not look as if it were obeyed; who is meant may come later."""
    when = "of the whole run" if is_over else "so far"
    for text, meant in unmatched(options, specs):
        log.warn(f"{text} {when}{meant}")


def nearest(pattern: str, specs: Sequence[ProcessSpec]) -> str:
    """` (did you mean 'dispatcher'?)`; empty where nothing is like it."""
    names = [name for spec in specs for name in (spec.label, spec.name)]
    near = difflib.get_close_matches(pattern, names, n=1)
    return f" (did you mean '{near[0]}'?)" if near else ""


def _patterns(options: RunOptions) -> Iterator[tuple[str, str]]:
    """(option, or place in a file; pattern) of each."""
    for pattern in options.required:
        yield "--required", pattern
    for word in options.budgets:
        yield "--budget", word.rpartition(":")[0]
    for pattern, where in options.file_names:
        yield f"{where}:", pattern
    told = {pattern for pattern, _ in options.file_names}  # its settings are among the following
    for pattern, _ in options.restart:
        if pattern not in told:
            yield "--restart", pattern
    for pattern, _ in options.stop:
        if pattern not in told:
            yield "--stop", pattern
    for pattern, limits in options.limits:
        if pattern not in told:
            named = "--limit" if limits.rlimits else "--cpus" if limits.cpus else "--nice"
            yield named, pattern
