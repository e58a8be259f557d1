"""The values of the options of the flight recorder."""

from __future__ import annotations

import re

from launcher.base.errors import UsageError
from launcher.base.model.run_options import RunOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

KEEP_S, KEEP_BYTES = 60.0, 256 * 1024**2
_UNITS = {"k": 1024, "M": 1024**2, "G": 1024**3}
_PART = re.compile(r"(\d+(?:\.\d+)?)(s|k|M|G)")
_LEAST_BYTES = 1024**2


def parse_mode(word: str) -> str:
    """`flight`, or `all`; ValueError."""
    if word not in ("", "all"):
        raise ValueError(f"'{word}' is not 'all'")
    return word or "flight"


def parse_keep(word: str) -> tuple[float, int]:
    """`60s,256M`: seconds and bytes, either of which may be left out; ValueError."""
    seconds, size = KEEP_S, KEEP_BYTES
    for part in word.split(","):
        match = _PART.fullmatch(part)
        if match is None:
            raise ValueError(f"'{part}' is neither a time such as 60s nor a size such as 256M")
        if match[2] == "s":
            seconds = float(match[1])
        else:
            size = round(float(match[1]) * _UNITS[match[2]])
    if seconds <= 0 or size < _LEAST_BYTES:
        raise ValueError(f"'{word}' is too little: at least some seconds and 1M")
    return seconds, size


def parse_topics(word: str) -> str:
    """A regular expression; ValueError."""
    try:
        re.compile(word)
    except re.error as error:
        raise ValueError(f"'{word}' is not a regular expression: {error}") from None
    return word


def check(options: RunOptions) -> None:
    """UsageError for options that exclude each other, or where a library is missing."""
    if options.record is None:
        raise UsageError("--record-keep and --record-topics need --record")
    if not options.control or not options.log_files:
        without = "--no-log-files" if options.control else "--no-control"
        raise UsageError(f"--record and {without} exclude each other")
    from launcher.packages.absent_ros import require

    require("--record", {"bag": "mcap"})


def settings_of(options: RunOptions, run_folder: str | None, socket: str) -> dict[str, Any]:
    """The settings of `launcher.bag.ros.flight`."""
    keep_s, keep_bytes = options.record_keep or (KEEP_S, KEEP_BYTES)
    return {
        "run_folder": run_folder,
        "socket": socket,
        "keep_s": keep_s,
        "keep_bytes": keep_bytes,
        "topics": options.record_topics,
        "everything": options.record == "all",
    }
