"""Log levels of ROS processes, as words of their command lines.

Imported only for a run whose options set one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from launcher.base.model.record import replace
from launcher.base.model.spec import ProcessSpec

OPTION = "--log-level"
ALL = "*"


def with_levels(
    spec: ProcessSpec, given: Iterable[tuple[str, tuple[str, str]]], names: Iterable[str]
) -> ProcessSpec:
    """The process with what (pattern, (logger or nothing, level)) set, all of which match it.

    A level of the process replaces all that its launch file sets, that of a logger those of this
    logger. One of its names counts before a pattern, and that before `*`; else the last.
    """
    ranked = sorted(given, key=lambda one: 2 if one[0] in names else int(one[0] != ALL))
    levels = dict(setting for _, setting in ranked)
    if not levels:
        return spec
    values = [f"{logger}:={level}" if logger else level for logger, level in levels.items()]
    words = [word for value in values for word in (OPTION, value)]
    # Behind `--ros-args` once more, since a `--` may have ended the words of ROS.
    return replace(spec, argv=(*_without(spec.argv, levels), "--ros-args", *words))


def _without(argv: Sequence[str], levels: Iterable[str]) -> list[str]:
    """The words without the levels that are replaced."""
    kept: list[str] = []
    is_ros = is_value = False
    for word in argv:
        if is_value:
            is_value = False
            logger = word.rpartition(":=")[0]
            if "" in levels or logger in levels:
                kept.pop()
                continue
        elif word in ("--ros-args", "--"):
            is_ros = word == "--ros-args"
        else:
            is_value = is_ros and word == OPTION
        kept.append(word)
    return kept
