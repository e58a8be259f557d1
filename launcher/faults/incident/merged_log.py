"""Reads the merged log of a run: each line with its time and its process."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from typing import NamedTuple

from launcher.output.lines import for_terminal
from launcher.output.logs.run_directory import MERGED

_STAMPED = re.compile(rb"(\d{9,11}\.\d{7}) (.*)", re.DOTALL)
_OF_PROCESS = re.compile(rb"\[([^\]]+)\] ?(.*)", re.DOTALL)
_OF_LAUNCHER = re.compile(rb"\[(?:DEBUG|INFO|WARNING|WARN|ERROR|FATAL|CRITICAL)\] \[")


class LoggedLine(NamedTuple):
    """`process` is None for the launcher."""

    wall_s: float
    process: str | None
    text: str


def merged_lines(folder: str) -> list[LoggedLine]:
    """The lines of `launch.log`, or of the file that `--log-file-name` named; [] if none.

    Those without a time have that of the line before.
    """
    path = _merged_in(folder)
    if path is None:
        return []
    with open(path, "rb") as file:
        return list(_lines(file.read()))


def _merged_in(folder: str) -> str | None:
    try:
        names = sorted(os.listdir(folder))
    except OSError:
        return None
    of_process = re.compile(r"-\d+(-stdout|-stderr)?\.log$")
    others = [name for name in names if name.endswith(".log") and not of_process.search(name)]
    name = MERGED if MERGED in names else next(iter(others), None)
    return None if name is None else os.path.join(folder, name)


def _lines(data: bytes) -> Iterator[LoggedLine]:
    at_s = 0.0
    for line in data.split(b"\n")[:-1]:
        process, text = None, line
        stamped = _STAMPED.fullmatch(line)
        if stamped is not None:
            at_s, text = float(stamped[1]), stamped[2]
            of_process = None if _OF_LAUNCHER.match(text) else _OF_PROCESS.fullmatch(text)
            if of_process is not None:
                process, text = of_process[1].decode(errors="replace"), of_process[2]
        yield LoggedLine(at_s, process, for_terminal(text).decode(errors="replace"))
