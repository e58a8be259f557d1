"""The line by which a process says that it is ready, as a regular expression."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from launcher.smoke.observe.facts import LogLine

SEARCHED = 50  # lines of each process
MIN_LETTERS = 6  # fewer are in any line
# `[INFO] [1795229956.758952768] [robot_3]: ` of rclpy and rclcpp.
_HEAD = re.compile(r"^\[(?:DEBUG|INFO)\] \[[\d.]+\] \[[^\]]*\]: |^\[[\d.]+\] \[[^\]]*\]: ")
_READY = re.compile(
    r"\b(?:ready|started|starting up|initiali[sz]ed|listening|running|configured|activated|active"
    r"|connected|loaded|online|up)\b",
    re.IGNORECASE,
)
# What may be another one in the next run: a word with a digit, a quotation, a value.
_VARYING = re.compile(r"""\S*\d\S*|["'`{(\[<=].*""")


def readiness(runs: Sequence[Sequence[LogLine]]) -> tuple[str, list[LogLine]] | None:
    """A regular expression and the line of each run that it matches first.

    The first line that says `ready` or the like, or else the first one at all, that every run has.
    """
    found = [dict(_texts(lines)) for lines in runs]
    if not found:
        return None
    common = [text for text in found[0] if all(text in other for other in found)]
    text = next((one for one in common if _READY.search(one)), next(iter(common), None))
    if text is None:
        return None
    pattern = re.sub(r"\\([ \-/:#&~])", r"\1", re.escape(text))  # where it need not be escaped
    return pattern, [texts[text] for texts in found]


def _texts(lines: Sequence[LogLine]) -> Iterator[tuple[str, LogLine]]:
    """The constant beginning of each line, and the first line that has it."""
    seen: set[str] = set()
    for line in lines[:SEARCHED]:
        text = constant(line)
        if text is not None and text not in seen:
            seen.add(text)
            yield text, line


def message(line: LogLine) -> str:
    """What the node said, without level, time and name."""
    return _HEAD.sub("", line.plain)


def constant(line: LogLine) -> str | None:
    """The part of the message before what may vary; None if it says too little, or a warning."""
    if line.level not in (None, "INFO", "DEBUG") or line.plain[:1].isspace():
        return None
    text = message(line)
    varying = _VARYING.search(text)
    text = (text if varying is None else text[: varying.start()]).strip()
    letters = sum(char.isalpha() for char in text)
    return text if letters >= MIN_LETTERS and "Traceback" not in text else None
