"""Parses budgets: `PATTERN:KEY=VALUE,...` of `--budget`, and the values in a supervision file.

    robot_*:memory=200M,cpu=80%,for=10,action=restart

cpu is percent of one core; memory is bytes, K, M and G are powers of 1024; threads and fds are
counts; for is seconds, rounded up since samples are taken once a second; action is warn, restart
(the process) or stop-run (or its short form `stop`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Union

from launcher.base.errors import UsageError
from launcher.base.model.record import replace
from launcher.base.text import did_you_mean
from launcher.run.monitor.budgets import Budget, BudgetAction

_LIMITS = {"cpu_percent", "memory_bytes", "threads", "fds"}
_UNITS = {"": 1, "K": 1024, "M": 1024**2, "G": 1024**3}


Value = Union[float, int, BudgetAction]


def parse_words(words: Iterable[str]) -> list[Budget]:
    """The budgets of command-line words; UsageError with the invalid word."""
    budgets = []
    for word in words:
        pattern, colon, text = word.rpartition(":")
        if not colon or not pattern:
            hint = "PATTERN:KEY=VALUE,..., as in 'robot_*:memory=200M,for=10,action=restart'"
            raise UsageError(f"invalid budget '{word}'", hint=hint)
        budgets.append(_budget(pattern, text.split(","), word))
    return budgets


def _budget(pattern: str, parts: Iterable[str], word: str) -> Budget:
    values: dict[str, Value] = {}
    for part in parts:
        key, equals, value = part.partition("=")
        key, value = key.strip(), value.strip()
        if not equals:
            raise UsageError(f"'{part}' in '{word}' has no value", hint=f"as in {EXAMPLES}")
        if key not in KEYS:
            raise _error(word, f"unknown key '{key}'", _suggestion(key, KEYS))
        if key in values:
            raise _error(word, f"'{key}' is given twice")
        try:
            values[key] = KEYS[key][1](value)
        except ValueError as error:
            raise _error(word, f"invalid value '{value}' for '{key}'", str(error)) from None
    budget = budget_of(pattern, values)
    if budget is None:
        raise _error(word, f"no limit for '{pattern}'", f"as in {EXAMPLES}")
    return budget


def budget_of(pattern: str, values: Mapping[str, Value]) -> Budget | None:
    """The budget of parsed values by key; None if none of them is a limit."""
    fields = {KEYS[key][0]: value for key, value in values.items()}
    if not fields.keys() & _LIMITS:
        return None
    return replace(Budget(pattern=pattern), **fields)


def _error(word: str, message: str, hint: str | None = None) -> UsageError:
    return UsageError(f"budget '{word}': {message}", hint=hint)


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


KEYS: dict[str, tuple[str, Callable[[str], Value]]] = {
    "cpu": ("cpu_percent", _percent),
    "memory": ("memory_bytes", _bytes),
    "threads": ("threads", _count),
    "fds": ("fds", _count),
    "for": ("for_s", _seconds),
    "action": ("action", _action),
}
EXAMPLES = "memory=200M, cpu=80%, threads=100 or fds=500"
