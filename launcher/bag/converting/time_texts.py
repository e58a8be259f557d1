"""Times in bags as users write them."""

from __future__ import annotations

import datetime
import decimal
from typing import NamedTuple

_EPOCH_FROM = 10**8  # seconds: recordings are shorter, and the epoch began more than 50 years ago
_MOST = 2**63 - 1


class Moment(NamedTuple):
    """Nanoseconds from the start of a bag, or since the epoch."""

    ns: int
    from_start: bool

    def at(self, start_ns: int) -> int:
        """Since the epoch, in a bag that begins at `start_ns`."""
        return start_ns + self.ns if self.from_start else self.ns


def moment(word: str) -> Moment:
    """`12.5` from the start, seconds since the epoch, or an ISO date; ValueError."""
    try:
        value = decimal.Decimal(word)
    except decimal.InvalidOperation:
        return Moment(_of_date(word), from_start=False)
    ns = _ns(value, word)
    return Moment(ns, from_start=ns < _EPOCH_FROM * 10**9)


def duration_ns(word: str) -> int:
    """A number of seconds, exactly; ValueError."""
    try:
        return _ns(decimal.Decimal(word), word)
    except decimal.InvalidOperation:
        raise ValueError(f"'{word}' is not a number of seconds") from None


def _ns(seconds: decimal.Decimal, word: str) -> int:
    if not seconds.is_finite() or not 0 <= seconds * 10**9 <= _MOST:
        why = ": it is below 0" if seconds.is_finite() and seconds < 0 else ""
        raise ValueError(f"'{word}' is not a number of seconds{why}")
    return int(seconds * 10**9)


def _of_date(word: str) -> int:
    """Local time, unless it says where."""
    try:
        date = datetime.datetime.fromisoformat(word[:-1] + "+00:00" if word[-1:] == "Z" else word)
        seconds = date.replace(microsecond=0).timestamp()
    except (ValueError, OverflowError, OSError):
        raise ValueError(
            f"'{word}' is neither a number of seconds nor a date such as 2026-11-27T14:03:05"
        ) from None
    return int(seconds) * 10**9 + date.microsecond * 1000
