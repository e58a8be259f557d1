"""Warnings about options for processes (`--required NAME`) that match no process.

Options from a file (`--budgets`) are named by their line in it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from launcher.base.model.run_options import RunOptions, matches
from launcher.base.model.spec import ProcessSpec
from launcher.base.text import did_you_mean
from launcher.run.logs.run_log import RunLog


def unmatched(options: RunOptions, specs: Sequence[ProcessSpec]) -> list[tuple[str, str]]:
    """(`--required 'dispacher' matches no process`, a suggestion) for each."""
    found = {}
    for place, pattern in _patterns(options):
        if not any(matches(pattern, spec) for spec in specs):
            found[f"{place} '{pattern}'"] = nearest(pattern, specs)
    return [(f"{what} matches no process", meant) for what, meant in found.items()]


def without_node(options: RunOptions, specs: Sequence[ProcessSpec]) -> list[str]:
    """`--log-level 'x' does not apply to x-1: ...` for each process that is no ROS node."""
    patterns = dict.fromkeys(pattern for pattern, _ in options.log_levels if pattern != "*")
    return [
        f"--log-level '{pattern}' does not apply to {spec.name}: it is not started as a ROS node"
        for pattern in patterns
        for spec in specs
        if spec.ros is None and matches(pattern, spec)
    ]


def warn_of_unmatched(
    options: RunOptions, specs: Sequence[ProcessSpec], log: RunLog, *, is_over: bool
) -> None:
    """Log a warning for each; not an error, since a process may still start later."""
    when = "of the whole run" if is_over else "so far"
    for text, meant in unmatched(options, specs):
        log.warn(f"{text} {when}{meant}")
    for text in () if is_over else without_node(options, specs):
        log.warn(text)


def nearest(pattern: str, specs: Sequence[ProcessSpec]) -> str:
    """` (did you mean 'dispatcher'?)`; empty if no name is similar."""
    hint = did_you_mean(pattern, [name for spec in specs for name in (spec.label, spec.name)])
    return f" ({hint})" if hint else ""


def _patterns(options: RunOptions) -> Iterator[tuple[str, str]]:
    """(option, or place in a file; pattern) of each."""
    for pattern in options.required:
        yield "--required", pattern
    for pattern in options.compose:
        yield "--compose", pattern
    for word in options.budgets:
        yield "--budget", word.rpartition(":")[0]
    for pattern, where in options.file_names:
        yield f"{where}:", pattern
    in_files = {pattern for pattern, _ in options.file_names}  # are among the following, too
    for option, settings in (("--restart", options.restart), ("--stop", options.stop)):
        yield from ((option, pattern) for pattern, _ in settings if pattern not in in_files)
    yield from (("--prefix", pattern) for pattern, _ in options.prefix)
    yield from (("--log-level", pattern) for pattern, _ in options.log_levels)
    for pattern, limits in options.limits:
        if pattern not in in_files:
            named = "--limit" if limits.rlimits else "--cpus" if limits.cpus else "--nice"
            yield named, pattern
