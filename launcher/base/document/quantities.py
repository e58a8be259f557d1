"""Times, windows, counts, rates and sizes: one regular expression each for parser and schema."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from launcher.base.document.fields import FieldType, shown

NUMBER = r"[0-9]+(?:\.[0-9]+)?"
_TIME_UNIT = r"(?:ms|s|sec|min)"
_TIME_FACTORS = {"": 1.0, "ms": 0.001, "s": 1.0, "sec": 1.0, "min": 60.0}
_PERIODS_S = {"s": 1.0, "sec": 1.0, "min": 60.0, "h": 3600.0}
_SIZE_FACTORS = {"": 1, "K": 1024, "M": 1024**2, "G": 1024**3}
_LIMIT = r"(?:<=|>=|<|>)"
_TO = r"(?:\.\.|to)"
DEFAULT_RATE_TOLERANCE = 0.1
INFINITY = float("inf")


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberRange:
    """Numbers from `low` to `high`, both included; `text` is the source text."""

    low: float
    high: float
    text: str

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high


def for_editors(pattern: str) -> str:
    """The pattern for JSON Schema, whose ECMAScript expressions name groups differently."""
    return re.sub(r"\(\?P<\w+>", "(?:", pattern)


def quantity(
    noun: str,
    example: str,
    pattern: str,
    make: Callable[[re.Match[str]], Any],
    *,
    whole: bool = False,
    needs_unit: bool = False,
) -> FieldType:
    """Text that matches `pattern`, or a plain number (`whole`: an integer) that does as text.

    With `needs_unit` no plain number does.
    """

    def parse(value: object) -> Any:
        is_number = isinstance(value, int if whole else int | float) and not isinstance(value, bool)
        text = _plain(value) if is_number else value
        match = re.fullmatch(pattern, text) if isinstance(text, str) else None
        if match is None:
            raise ValueError(f"invalid {noun} {shown(value)}: expected {example}")
        return make(match)

    schema = {"type": "string", "pattern": f"^(?:{for_editors(pattern)})$"}
    if needs_unit:
        return FieldType(parse, schema)
    number = {"type": "integer" if whole else "number", "minimum": 0}
    return FieldType(parse, {"anyOf": [schema, number]})


def _plain(value: object) -> str:
    """A number without exponent, for the patterns."""
    return f"{value:.9f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)


def _window(match: re.Match[str]) -> NumberRange:
    factor = _TIME_FACTORS[match["unit"] or ""]
    low = float(match["low"] or 0) * factor
    return _ordered(low, float(match["number"]) * factor, match)


def _ordered(low: float, high: float, match: re.Match[str]) -> NumberRange:
    if low > high:
        raise ValueError(f"'{match[0]}' ends before it begins")
    return NumberRange(low=low, high=high, text=match[0])


def _count(match: re.Match[str]) -> NumberRange:
    if match["exact"]:
        return NumberRange(low=int(match["exact"]), high=int(match["exact"]), text=match[0])
    if match["limit"]:
        return _limited(match["limit"], int(match["bound"]), 1, match[0])
    return _ordered(int(match["low"]), int(match["high"]), match)


def _limited(sign: str, bound: float, step: float, text: str) -> NumberRange:
    if sign.startswith("<"):
        return NumberRange(low=0, high=bound - step * (sign == "<"), text=text)
    return NumberRange(low=bound + step * (sign == ">"), high=INFINITY, text=text)


def _rate(match: re.Match[str]) -> NumberRange:
    if match["limit"]:
        return _limited(match["limit"], float(match["bound"]), 0.0, match[0])
    if match["low"]:
        return _ordered(float(match["low"]), float(match["high"]), match)
    middle = float(match["exact"])
    tolerance = DEFAULT_RATE_TOLERANCE * middle
    if match["tolerance"]:
        tolerance = float(match["tolerance"])
        if match["percent"]:
            tolerance *= middle / 100
    return NumberRange(low=max(0.0, middle - tolerance), high=middle + tolerance, text=match[0])


def _growth(match: re.Match[str]) -> float:
    size = float(match["number"]) * _SIZE_FACTORS[match["unit"] or ""]
    return size / _PERIODS_S[match["period"]]


def _exit(match: re.Match[str]) -> int:
    if match["number"]:
        return int(match["number"])
    try:
        return -int(signal.Signals[match["signal"]])
    except KeyError:
        raise ValueError(f"unknown signal '{match['signal']}'") from None


DURATION_PATTERN = rf"(?P<number>{NUMBER}) *(?P<unit>{_TIME_UNIT})?"
DURATION = quantity(
    "time",
    "8 s, 500 ms or 2 min",
    DURATION_PATTERN,
    lambda match: float(match["number"]) * _TIME_FACTORS[match["unit"] or ""],
)
parse_duration = DURATION.parse


def parse_positive_duration(value: object) -> float:
    """Seconds; ValueError if it is no time, or none above 0 s."""
    time_s: float = DURATION.parse(value)
    if time_s <= 0.0:
        raise ValueError("the time must be longer than 0 s")
    return time_s


WINDOW = quantity(
    "time",
    "8 s, or 5 to 8 s",
    rf"(?:(?P<low>{NUMBER}) *{_TO} *)?{DURATION_PATTERN}",
    _window,
)
COUNT = quantity(
    "count",
    "3, '>= 2' or '2 to 4'",
    rf"(?P<exact>[0-9]+)|(?P<limit>{_LIMIT}) *(?P<bound>[0-9]+)"
    rf"|(?P<low>[0-9]+) *{_TO} *(?P<high>[0-9]+)",
    _count,
    whole=True,
)
RATE = quantity(
    "rate",
    "1 Hz ± 20 %, 0.9 to 1.1 Hz or '>= 5 Hz'",
    rf"(?P<exact>{NUMBER}) *(?:Hz)?"
    rf"(?: *(?:±|\+/?-) *(?P<tolerance>{NUMBER}) *(?:(?P<percent>%)|Hz)?)?"
    rf"|(?P<limit>{_LIMIT}) *(?P<bound>{NUMBER}) *(?:Hz)?"
    rf"|(?P<low>{NUMBER}) *{_TO} *(?P<high>{NUMBER}) *(?:Hz)?",
    _rate,
)
SIZE = quantity(
    "size",
    "200 MB (powers of 1024)",
    rf"(?P<number>{NUMBER}) *(?P<unit>[KMG])?i?B?",
    lambda match: int(float(match["number"]) * _SIZE_FACTORS[match["unit"] or ""]),
)
GROWTH = quantity(
    "growth",
    "1 MB/min (powers of 1024)",
    rf"(?P<number>{NUMBER}) *(?P<unit>[KMG])?i?B? */ *(?P<period>{'|'.join(_PERIODS_S)})",
    _growth,  # bytes per second
    needs_unit=True,
)
PERCENT = quantity(
    "percentage",
    "80 % (of one core)",
    rf"(?P<number>{NUMBER}) *%?",
    lambda match: float(match["number"]),
)
EXIT = quantity(
    "exit code",
    "0, 3 or SIGKILL",
    r"(?P<number>[0-9]+)|(?P<signal>SIG[A-Z0-9]+)",
    _exit,
    whole=True,
)


def seconds_text(value_s: float) -> str:
    """`0.25 s`, `8.1 s`."""
    return f"{value_s:.2f} s" if value_s < 1 else f"{value_s:.1f} s"
