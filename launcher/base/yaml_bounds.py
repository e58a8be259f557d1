"""YAML of files that others have written: bounds on size, depth, and what aliases repeat.

The C library reads nested entries recursively, and crashes if they are too deep; the other reader
ends in a RecursionError.
"""

from __future__ import annotations

import re
from typing import Any

import yaml
from yaml.reader import ReaderError

MAX_CHARACTERS = 16 * 1024 * 1024
MAX_DEPTH = 100
MAX_VALUES = 1_000_000  # with all aliases expanded
MAX_NUMBER = 1000  # characters; numbers to base 60 take quadratic time

LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_NUMBER = re.compile(r"[-+]?[0-9][0-9_.]*(:[0-9_.:]*)?")  # not 0x1f, which takes linear time
# raised by PyYAML for `!!bool x`, `!!timestamp x` and so on
_TAG_ERRORS = (LookupError, AttributeError, TypeError, OverflowError)


def load(text: str, loader: Any = None) -> Any:
    """The value of a YAML text, None if it is empty; raises yaml.YAMLError only."""
    try:
        if len(text) > MAX_DEPTH:  # a shorter one is within all bounds
            check(text, loader)
        return yaml.load(text, Loader=loader or LOADER)
    except ValueError as error:  # an invalid date, `!!int x`
        raise yaml.YAMLError(str(error)) from error
    except _TAG_ERRORS as error:
        raise yaml.YAMLError("a value does not fit its tag (!!)") from error


def compose(text: str, loader: Any = None) -> Any:
    """The tree of nodes, None if the text is empty; raises yaml.YAMLError."""
    check(text, loader)
    return yaml.compose(text, Loader=loader or LOADER)


def sentence(error: Exception, path: str) -> str:
    """What is wrong with the YAML of a file, in one line: `FILE:LINE: invalid YAML: ...`."""
    mark = place_of(error)
    where = path if mark is None else f"{path}:{mark.line + 1}"
    return f"{where}: invalid YAML: {message_of(error)}"


def place_of(error: Exception) -> Any:
    """The mark of PyYAML where the error is (line and column from 0); None if it has none."""
    return getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)


def message_of(error: Exception) -> str:
    """What is wrong, in one line without the place."""
    if isinstance(error, ReaderError):
        return f"the character U+{error.character:04X} is not allowed"
    message = getattr(error, "problem", None) or str(error)
    if message.startswith("but "):
        message = f"{getattr(error, 'context', None)}, {message}"
    return " ".join(message.split())


def check(text: str, loader: Any = None) -> None:
    """Raise yaml.YAMLError if the text is not YAML, or beyond the bounds."""
    if len(text) > MAX_CHARACTERS:
        raise yaml.YAMLError(f"it has more than {MAX_CHARACTERS >> 20} MiB")
    bounds = _Bounds()
    for event in yaml.parse(text, Loader=loader or LOADER):
        problem = bounds.problem(event)
        if problem is not None:
            mark: Any = event.start_mark
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=mark)


class _Bounds:
    """Counts values; an alias counts as all that it stands for."""

    def __init__(self) -> None:
        self._total = 0
        self._open: list[tuple[str | None, int]] = []  # (anchor, values before it)
        self._sizes: dict[str, int] = {}

    def problem(self, event: object) -> str | None:
        """What is wrong with the next event of the text; None if nothing is."""
        if isinstance(event, yaml.AliasEvent):
            if any(anchor == event.anchor for anchor, _ in self._open):
                return "an entry contains itself"
            self._total += self._sizes.get(event.anchor or "", 1)
        elif isinstance(event, yaml.CollectionStartEvent):
            self._open.append((event.anchor, self._total))
            self._total += 1
            if len(self._open) > MAX_DEPTH:
                return f"more than {MAX_DEPTH} levels"
        elif isinstance(event, yaml.CollectionEndEvent):
            anchor, before = self._open.pop()
            if anchor is not None:
                self._sizes[anchor] = self._total - before
        elif isinstance(event, yaml.ScalarEvent):
            self._total += 1
            if event.anchor is not None:
                self._sizes[event.anchor] = 1
            if len(event.value) > MAX_NUMBER and _is_number(event):
                return f"a number of more than {MAX_NUMBER} characters"
        return f"more than {MAX_VALUES} values" if self._total > MAX_VALUES else None


def _is_number(event: yaml.ScalarEvent) -> bool:
    return event.implicit[0] and _NUMBER.fullmatch(event.value) is not None
