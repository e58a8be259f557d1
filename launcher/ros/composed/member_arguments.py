"""What of the arguments of a program applies to its nodes."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

_LEVELS = {"debug": 10, "info": 20, "warn": 30, "error": 40, "fatal": 50, "unset": 0}
_LOG_LEVEL = "--log-level"


def ros_words(words: Sequence[str]) -> list[str]:
    """Those between `--ros-args` and `--`."""
    found: list[str] = []
    is_ros = False
    for word in words:
        if word in ("--ros-args", "--"):
            is_ros = word == "--ros-args"
        elif is_ros:
            found.append(word)
    return found


def node_arguments(words: Sequence[str]) -> list[str]:
    """For `cli_args` of a node: all but the log levels, which are those of the process in rcl."""
    kept: list[str] = []
    ros = iter(ros_words(words))
    for word in ros:
        if word == _LOG_LEVEL:
            next(ros, None)
        else:
            kept.append(word)
    return ["--ros-args", *kept, "--"] if kept else []


def log_levels(words: Sequence[str]) -> list[tuple[str, int]]:
    """(logger, or nothing for the logger of each node; level)."""
    ros = ros_words(words)
    found = []
    for option, value in itertools.pairwise(ros):
        if option == _LOG_LEVEL:
            logger, _, level = value.rpartition(":=")
            if level.lower() not in _LEVELS:
                raise RuntimeError(f"Couldn't parse log level: '{_LOG_LEVEL} {value}'")
            found.append((logger, _LEVELS[level.lower()]))
    return found
