"""An argument of a tool: its JSON Schema, and the check of a value."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from launcher.base.model.record import Record, replace
from launcher.base.option import Option
from launcher.base.run_verb import BadCallError

_KINDS: dict[str, dict[str, Any]] = {
    "flag": {"type": "boolean"},
    "text": {"type": "string"},
    "count": {"type": "integer", "minimum": 0},
    "seconds": {"type": "number", "exclusiveMinimum": 0},
    "signal": {"type": "string"},
    "texts": {"type": "array", "items": {"type": "string"}},
}
_EXPECTED = {
    "flag": "true or false",
    "text": "a string",
    "count": "a whole number of at least 0",
    "seconds": "a number of seconds above 0",
    "signal": "the name or number of a signal",
    "texts": "a list of strings",
}
# What words of a command line stand for, by how its help shows them.
_BY_METAVAR = {"S": "seconds", "N": "count"}


class ToolArgument(Record):
    """`kind` is one of the control protocol's (`Option.kind`), or `texts`, a list of them.

    `default` is used, and shown, where the argument is absent; a number is at most `most`; of
    `texts`, there are at most `most`, and at least one if it is required.
    """

    name: str
    kind: str
    help: str = ""
    is_required: bool = False
    choices: tuple[str, ...] = ()
    default: object = None
    most: int | None = None

    @classmethod
    def of(cls, option: Option) -> ToolArgument:
        """An option in a request to the control socket."""
        help_text = option.help
        if option.is_flag and option.value is False:  # `--no-wait` sets `wait` to false
            help_text = f"true, or false: {help_text}"
        return cls(option.name, option.kind, help_text, choices=option.choices)

    @classmethod
    def of_words(cls, option: Option) -> ToolArgument:
        """An option or argument of a command line."""
        found = cls.of(option)
        kind = "flag" if option.is_flag else _BY_METAVAR.get(option.metavar, "text")
        if option.repeat == "all" or option.count in ("*", "+", "...", "text"):
            kind = "texts"
        return replace(found, kind=kind, is_required=not option.flags and option.count in "1+")

    def schema(self) -> dict[str, Any]:
        """Its JSON Schema."""
        found = dict(_KINDS[self.kind])
        if self.help:
            found["description"] = self.help
        if self.choices:
            found["enum"] = list(self.choices)
        if self.most is not None:
            found["maxItems" if self.kind == "texts" else "maximum"] = self.most
        if self.kind == "texts" and self.is_required:
            found["minItems"] = 1
        if self.default is not None:
            found["default"] = self.default
        return found

    def check(self, value: object, of: str) -> Any:
        """The value for a tool of this name; BadCallError."""
        if not _IS[self.kind](value):
            self._refuse(of, f"must be {_EXPECTED[self.kind]}")
        if self.choices and value not in self.choices:
            self._refuse(of, f"must be one of {', '.join(self.choices)}")
        if self.most is not None:
            size: Any = len(value) if isinstance(value, list) else value
            if size > self.most:
                unit = " values" if self.kind == "texts" else ""
                self._refuse(of, f"must be at most {self.most}{unit}")
        return value

    def _refuse(self, of: str, why: str) -> None:
        raise BadCallError("bad-option", f"{of}: '{self.name}' {why}")

    def from_words(self, words: Sequence[str], of: str) -> Any:
        """The value that words of an address mean, one for each `name=word`; BadCallError."""
        if self.kind == "texts":
            return list(words)
        word = words[-1]
        if self.kind == "flag":
            value = {"true": True, "1": True, "": True, "false": False, "0": False}.get(word)
            return self.check(value, of)
        if self.kind in ("count", "seconds"):
            try:
                return self.check(int(word) if self.kind == "count" else float(word), of)
            except ValueError:
                self._refuse(of, f"must be {_EXPECTED[self.kind]}")
        return word


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _is_seconds(value: Any) -> bool:
    return _is_number(value) and value > 0 and math.isfinite(value)


def _is_text(value: object) -> bool:
    """Whether it is text that a command line can have."""
    if not isinstance(value, str) or "\0" in value:
        return False
    try:
        value.encode()
    except UnicodeEncodeError:  # half of a pair of surrogates
        return False
    return True


_IS: dict[str, Callable[[Any], bool]] = {
    "flag": lambda value: isinstance(value, bool),
    "text": _is_text,
    "count": lambda value: _is_number(value) and isinstance(value, int) and value >= 0,
    "seconds": _is_seconds,
    "signal": lambda value: isinstance(value, (str, int)) and not isinstance(value, bool),
    "texts": lambda value: isinstance(value, list) and all(map(_is_text, value)),
}
