"""Parses budgets, from `--budget` and from the YAML file of `--budgets`.

On the command line, `PATTERN:KEY=VALUE,...`::

    robot_*:memory=200M,cpu=80%,for=10,action=restart

and in a YAML file the same::

    robot_*:
      memory: 200M
      cpu: 80%
      for: 10
      action: restart

The file may also say how a process is restarted, stopped and limited, in the words of the options::

    robot_*:
      restart: on-failure,max=5
      stop: int:2,term:1
      nice: 5
      cpus: 0-1
      limit: nofile=256,core=0

cpu is percent of one core; memory is bytes, K, M and G are powers of 1024; threads and fds are
counts; for is seconds, rounded up since samples are taken once a second; action is warn, restart
(the process) or stop-run (or its short form `stop`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple, Union

from launcher.engine.monitor.budgets import Budget, BudgetAction
from launcher.errors import UsageError
from launcher.model.record import replace
from launcher.text import did_you_mean

if TYPE_CHECKING:
    import yaml

SETTINGS = ("restart", "stop", "nice", "cpus", "limit")  # as the options of these names
_UNITS = {"": 1, "K": 1024, "M": 1024**2, "G": 1024**3}


def parse_words(words: Iterable[str]) -> list[Budget]:
    """The budgets of command-line words; UsageError with the invalid word."""
    budgets = []
    for word in words:
        pattern, colon, text = word.rpartition(":")
        if not colon or not pattern:
            hint = "PATTERN:KEY=VALUE,..., as in 'robot_*:memory=200M,for=10,action=restart'"
            raise UsageError(f"invalid budget '{word}'", hint=hint)
        entries = []
        for part in text.split(","):
            key, equals, value = part.partition("=")
            if not equals:
                raise UsageError(f"'{part}' in '{word}' has no value", hint=f"as in {_EXAMPLES}")
            entries.append(_Entry(key.strip(), value.strip()))
        budgets.append(_budget(pattern, entries, _Place(f"budget '{word}'")))
    return budgets


def text_of(path: str) -> str:
    """Contents of a file of budgets; UsageError."""
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read the budgets: {error}") from error


def parse_yaml(text: str, path: str) -> list[Budget]:
    """The budgets in the text of a YAML file; UsageError with `path` and the line."""
    budgets = []
    for pattern, entries, place in _patterns(text, path):
        limits = [entry for entry in entries if entry.key not in SETTINGS]
        if limits or not entries:
            budgets.append(_budget(pattern, limits, place))
    return budgets


class Setting(NamedTuple):
    """An option for processes in the file, other than a budget; parsed like that option."""

    pattern: str
    key: str
    value: str
    place: _Place


def settings_in(text: str, path: str) -> list[Setting]:
    """The settings in the text of a YAML file, in order; UsageError."""
    return [
        Setting(pattern, entry.key, entry.value, entry.place or place)
        for pattern, entries, place in _patterns(text, path)
        for entry in entries
        if entry.key in SETTINGS
    ]


def names_in(text: str, path: str) -> list[tuple[str, str]]:
    """The patterns in the text of a YAML file, each with its place (`budgets.yaml:3`)."""
    return [(pattern, place.where) for pattern, _, place in _patterns(text, path)]


def _patterns(text: str, path: str) -> Iterator[tuple[str, list[_Entry], _Place]]:
    import yaml  # here: most runs have no such file

    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = _Place(path, 1 if mark is None else mark.line + 1, text)
        raise place.error(error.problem or "invalid YAML") from error
    except yaml.YAMLError as error:
        raise UsageError(f"{path}: invalid YAML: {error}") from error
    if root is None:
        return
    start = _Place(path, text=text)
    expected = f"limits, as in {_EXAMPLES.replace('=', ': ')}"
    for name, node in _pairs(root, start, "patterns, each with its limits"):
        entries = []
        for key, value in _pairs(node, start, expected):
            place = start.of(value)
            if not isinstance(value, yaml.ScalarNode):
                raise place.error(f"'{key.value}' takes one value")
            entries.append(_Entry(key.value, value.value, place))
        yield name.value, entries, start.of(name)


def _pairs(
    node: yaml.Node, start: _Place, expected: str
) -> Iterator[tuple[yaml.ScalarNode, yaml.Node]]:
    """The keys, which must be plain, and the values of a mapping."""
    import yaml

    if not isinstance(node, yaml.MappingNode):
        raise start.of(node).error(f"expected a mapping of {expected}")
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode):
            raise start.of(key).error("expected a plain word as the key")
        yield key, value


class _Place(NamedTuple):
    """Where something was written: a file and a line, or a word of the command line."""

    name: str
    line: int | None = None
    text: str = ""

    def of(self, node: yaml.Node) -> _Place:
        """The place of this node in the same file."""
        return _Place(self.name, node.start_mark.line + 1, self.text)

    @property
    def where(self) -> str:
        """As `budgets.yaml:3`."""
        return self.name if self.line is None else f"{self.name}:{self.line}"

    def error(self, message: str, hint: str | None = None) -> UsageError:
        if self.line is None:
            return UsageError(f"{self.name}: {message}", hint=hint)
        lines = self.text.splitlines()
        source = lines[self.line - 1] if self.line <= len(lines) else None
        return UsageError(message, hint=hint, where=self.where, source_line=source)


class _Entry(NamedTuple):
    """One KEY=VALUE and its own place, where it has one."""

    key: str
    value: str
    place: _Place | None = None


_Value = Union[float, int, BudgetAction]


def _budget(pattern: str, entries: Sequence[_Entry], place: _Place) -> Budget:
    fields: dict[str, _Value] = {}
    for entry in entries:
        here = entry.place or place
        if entry.key not in _KEYS:
            known = _KEYS if entry.place is None else [*_KEYS, *SETTINGS]
            raise here.error(f"unknown key '{entry.key}'", _suggestion(entry.key, known))
        field, read = _KEYS[entry.key]
        if field in fields:
            raise here.error(f"'{entry.key}' is given twice")
        try:
            fields[field] = read(entry.value)
        except ValueError as error:
            raise here.error(
                f"invalid value '{entry.value}' for '{entry.key}'", str(error)
            ) from None
    if not fields.keys() & {"cpu_percent", "memory_bytes", "threads", "fds"}:
        raise place.error(f"no limit for '{pattern}'", f"as in {_EXAMPLES}")
    return replace(Budget(pattern=pattern), **fields)


def _suggestion(word: str, known: Collection[str]) -> str:
    return did_you_mean(word, known) or f"known: {', '.join(known)}"


def _number(text: str, what: str) -> float:
    """A number of at least 0 without an exponent; ValueError(what)."""
    if not re.fullmatch(r"\d+(\.\d*)?|\.\d+", text) or math.isinf(float(text)):
        raise ValueError(what)
    return float(text)


def _percent(text: str) -> float:
    return _number(text.removesuffix("%").strip(), "percent of one core, as in 80%")


def _bytes(text: str) -> int:
    match = re.fullmatch(r"(.*?)\s*([KMG]?)(?:i?B)?", text, re.IGNORECASE)
    what = "bytes, as in 200M or 1.5G"
    if match is None:
        raise ValueError(what)
    return int(_number(match[1], what) * _UNITS[match[2].upper()])


def _count(text: str) -> int:
    if not re.fullmatch(r"[0-9]+", text):
        raise ValueError("a whole number, as in 100")
    return int(text)


def _seconds(text: str) -> float:
    return _number(text.removesuffix("s").strip(), "seconds, as in 10")


def _action(text: str) -> BudgetAction:
    if text == "stop":
        return BudgetAction.STOP_RUN
    try:
        return BudgetAction(text)
    except ValueError:
        raise ValueError(_suggestion(text, [action.value for action in BudgetAction])) from None


_KEYS: dict[str, tuple[str, Callable[[str], _Value]]] = {
    "cpu": ("cpu_percent", _percent),
    "memory": ("memory_bytes", _bytes),
    "threads": ("threads", _count),
    "fds": ("fds", _count),
    "for": ("for_s", _seconds),
    "action": ("action", _action),
}
_EXAMPLES = "memory=200M, cpu=80%, threads=100 or fds=500"
