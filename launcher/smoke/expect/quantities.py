"""Quantities: times, windows, counts, rates and sizes as people write them in expectations.

Each is a `Quantity`: one regular expression, which the schema for editors uses as well, and a
function that makes a value of the match. Plain numbers are taken where they are clear.
"""

from __future__ import annotations

import re
import signal
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

NUMBER = r"[0-9]+(?:\.[0-9]+)?"
_TIME_UNIT = r"(?:ms|s|sec|min)"
_TIME_FACTORS = {"": 1.0, "ms": 0.001, "s": 1.0, "sec": 1.0, "min": 60.0}
_SIZE_FACTORS = {"": 1, "K": 1024, "M": 1024**2, "G": 1024**3}
_LIMIT = r"(?:<=|>=|<|>)"
_TO = r"(?:\.\.|to)"
DEFAULT_RATE_TOLERANCE = 0.1
INFINITY = float("inf")


@dataclass(frozen=True, slots=True, kw_only=True)
class Span:
    """Numbers from `low` to `high`, both included; `text` is how it was written."""

    low: float
    high: float
    text: str

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """How something is written: `pattern` for text, whether a plain number will do, an example.

    `lowest` is the least plain number; `whole` asks for an integer.
    """

    noun: str
    example: str
    pattern: str
    make: Callable[[re.Match[str]], Any]
    takes_number: bool = True
    whole: bool = False
    flags: str = ""

    def parse(self, value: object) -> Any:
        """The value; ValueError with a sentence."""
        number = isinstance(value, int if self.whole else int | float)
        if number and self.takes_number and not isinstance(value, bool):
            match = re.fullmatch(self.pattern, _plain(value))
        else:
            match = re.fullmatch(self.pattern, value) if isinstance(value, str) else None
        if match is None:
            raise ValueError(f"{value!r} is no {self.noun}, which is written as {self.example}")
        return self.make(match)

    @property
    def schema(self) -> dict[str, object]:
        """The same for editors."""
        text: dict[str, object] = {
            "type": "string",
            "pattern": f"^(?:{for_editors(self.pattern)})$",
        }
        if not self.takes_number:
            return text
        kind = "integer" if self.whole else "number"
        return {"anyOf": [text, {"type": kind, "minimum": 0}]}


def _plain(value: object) -> str:
    """A number without exponent, as the patterns want it."""
    return f"{value:.9f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)


def _seconds(match: re.Match[str]) -> float:
    return float(match["number"]) * _TIME_FACTORS[match["unit"] or ""]


def _window(match: re.Match[str]) -> Span:
    factor = _TIME_FACTORS[match["unit"] or ""]
    low = float(match["low"] or 0) * factor
    return _ordered(low, float(match["number"]) * factor, match)


def _ordered(low: float, high: float, match: re.Match[str]) -> Span:
    if low > high:
        raise ValueError(f"'{match[0]}' ends before it begins")
    return Span(low=low, high=high, text=match[0])


def _count(match: re.Match[str]) -> Span:
    if match["exact"]:
        return Span(low=int(match["exact"]), high=int(match["exact"]), text=match[0])
    if match["limit"]:
        return _limited(match["limit"], int(match["bound"]), 1, match[0])
    return _ordered(int(match["low"]), int(match["high"]), match)


def _limited(sign: str, bound: float, step: float, text: str) -> Span:
    if sign.startswith("<"):
        return Span(low=0, high=bound - step * (sign == "<"), text=text)
    return Span(low=bound + step * (sign == ">"), high=INFINITY, text=text)


def _rate(match: re.Match[str]) -> Span:
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
    return Span(low=max(0.0, middle - tolerance), high=middle + tolerance, text=match[0])


def _size(match: re.Match[str]) -> int:
    return int(float(match["number"]) * _SIZE_FACTORS[match["unit"] or ""])


def _percent(match: re.Match[str]) -> float:
    return float(match["number"])


def _exit(match: re.Match[str]) -> int:
    if match["number"]:
        return int(match["number"])
    try:
        return -int(signal.Signals[match["signal"]])
    except KeyError:
        raise ValueError(f"there is no signal '{match['signal']}'") from None


DURATION = Quantity(
    noun="time",
    example="8 s, 500 ms or 2 min",
    pattern=rf"(?P<number>{NUMBER}) *(?P<unit>{_TIME_UNIT})?",
    make=_seconds,
)
WINDOW = Quantity(
    noun="time or pair of times",
    example="8 s, or 5 to 8 s",
    pattern=rf"(?:(?P<low>{NUMBER}) *{_TO} *)?(?P<number>{NUMBER}) *(?P<unit>{_TIME_UNIT})?",
    make=_window,
)
COUNT = Quantity(
    noun="count",
    example="3, '>= 2' or '2 to 4'",
    pattern=rf"(?P<exact>[0-9]+)|(?P<limit>{_LIMIT}) *(?P<bound>[0-9]+)"
    rf"|(?P<low>[0-9]+) *{_TO} *(?P<high>[0-9]+)",
    make=_count,
    whole=True,
)
RATE = Quantity(
    noun="rate",
    example="1 Hz ± 20 %, 0.9 to 1.1 Hz or '>= 5 Hz'",
    pattern=rf"(?P<exact>{NUMBER}) *(?:Hz)?"
    rf"(?: *(?:±|\+/?-) *(?P<tolerance>{NUMBER}) *(?:(?P<percent>%)|Hz)?)?"
    rf"|(?P<limit>{_LIMIT}) *(?P<bound>{NUMBER}) *(?:Hz)?"
    rf"|(?P<low>{NUMBER}) *{_TO} *(?P<high>{NUMBER}) *(?:Hz)?",
    make=_rate,
)
SIZE = Quantity(
    noun="size",
    example="200 MB (powers of 1024)",
    pattern=rf"(?P<number>{NUMBER}) *(?P<unit>[KMG])?i?B?",
    make=_size,
)
PERCENT = Quantity(
    noun="percentage",
    example="80 % (of one core)",
    pattern=rf"(?P<number>{NUMBER}) *%?",
    make=_percent,
)
EXIT = Quantity(
    noun="exit code",
    example="0, 3 or SIGKILL",
    pattern=r"(?P<number>[0-9]+)|(?P<signal>SIG[A-Z0-9]+)",
    make=_exit,
    whole=True,
)


def printable(text: str) -> str:
    """The text with control characters as escapes, so that it cannot steer a terminal."""
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() or c in "\n\t" else c.encode("unicode_escape").decode() for c in text
    )


def seconds_text(value_s: float) -> str:
    """A time for people: `0.25 s`, `8.1 s`, `125 s`."""
    return f"{value_s:.2f} s" if value_s < 1 else f"{value_s:.1f} s"


def for_editors(pattern: str) -> str:
    """The pattern as ECMAScript, and so JSON Schema, has it: groups are named otherwise there."""
    return re.sub(r"\(\?P<\w+>", "(?:", pattern)
