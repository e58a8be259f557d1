"""Long arrays: numbers as text, a piece at a time, as PyYAML would write them.

PyYAML makes a node and several events of each number, which costs ten microseconds and three
hundred bytes. So a long array is a token while it writes the rest, and stands there afterwards.
"""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Iterator
from typing import Any

LONG = 1024  # below it there is nothing to gain
_PIECE = 65536
_BYTES = [str(number) for number in range(256)]
_SPECIAL = {"nan": ".nan", "inf": ".inf", "-inf": "-.inf"}
# No text of a message can know it, so none is taken for an array.
_PREFIX = f"array-{os.urandom(12).hex()}-"
_TOKEN = re.compile(f"{_PREFIX}(\\d+)-")
_LEAD = re.compile(r"(?:- | )*")


class LongArray:
    """An array of numbers, and what follows its last one."""

    _numbers = itertools.count()

    def __init__(self, values: Any, more: list[str]) -> None:
        self.values = values
        self._more = more
        self.token = f"{_PREFIX}{next(self._numbers)}-"

    def pieces(self, separator: str) -> Iterator[str]:
        """The numbers in YAML, each behind a separator."""
        for piece in _pieces(self.values, _yaml_words):
            yield separator + separator.join(piece)
        for word in self._more:
            yield separator + word


def csv_text(values: Any) -> str:
    """The numbers between commas, as Python writes them."""
    return ",".join(",".join(piece) for piece in _pieces(values, _words))


def _pieces(values: Any, words: Any) -> Iterator[Iterator[str]]:
    for start in range(0, len(values), _PIECE):
        yield words(values[start : start + _PIECE])


def _words(values: Any) -> Iterator[str]:
    if getattr(values, "typecode", None) == "B":
        return map(_BYTES.__getitem__, values)
    return map(str, values.tolist())


def _yaml_words(values: Any) -> Iterator[str]:
    is_float = values.typecode in "fd" if hasattr(values, "typecode") else values.dtype.kind == "f"
    return map(_float_word, values.tolist()) if is_float else _words(values)


def _float_word(value: float) -> str:
    word = repr(value)
    if word in _SPECIAL:
        return _SPECIAL[word]
    # without a dot it would be read as a string
    return word.replace("e", ".0e", 1) if "e" in word and "." not in word else word


def with_arrays(text: str, arrays: dict[str, LongArray], *, flow: bool) -> Iterator[str]:
    """YAML with the arrays in the place of their tokens."""
    end = 0
    for match in _TOKEN.finditer(text):
        array = arrays[match[0]]
        if flow:
            yield text[end : match.start()] + "["
            pieces = array.pieces(", ")
            yield next(pieces)[2:]
            yield from pieces
            yield "]"
        else:
            yield text[end : match.start() - 1]  # the blank behind the name of the field
            yield from array.pieces(f"\n{_indent(text, match.start())}- ")
        end = match.end()
    yield text[end:]


def _indent(text: str, place: int) -> str:
    """Blanks up to the column of the field on this line."""
    lead = _LEAD.match(text, text.rfind("\n", 0, place) + 1)
    return " " * (len(lead[0]) if lead else 0)
