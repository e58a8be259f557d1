"""Formats messages like `ros2 topic echo`: YAML, CSV, JSON or raw, whole or one field."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from launcher.base.errors import UsageError
from launcher.base.ros_errors import VerbError
from launcher.base.text import typed_error
from launcher.posix.dispositions import Endable
from launcher.posix.json_output import json_line
from launcher.ros.messages.to_yaml import (
    Style,
    dump,
    is_list,
    to_csv,
    to_plain,
    yaml_pieces,
)
from launcher.ros.topics.listener import ReceivedMessage
from launcher.ros.verb import to_json_plain

Check = Callable[[Any], bool]
_STEP = re.compile(r"\[-?\d+\]|[^.\[]+|\[.*")  # of a path: `[2]` or a name
# Of ros2cli's MessageInfo, in its order.
_INFO = (
    "source_timestamp",
    "received_timestamp",
    "publication_sequence_number",
    "reception_sequence_number",
)


def compiled_filter(expression: str | None) -> Check | None:
    """A check of a message `m`; UsageError if the expression is not valid Python."""
    if expression is None:
        return None
    try:
        code = compile(expression, "--filter", "eval")
    except SyntaxError as error:
        raise UsageError(f"--filter is not a Python expression: {error.msg}") from None

    def check(message: Any) -> bool:
        try:
            with Endable():
                return bool(eval(code, {"m": message}))  # the user's own, as with ros2cli
        except Exception as error:
            text = f"--filter failed: {typed_error(error)}"
            raise VerbError(text, hint="the message is called m") from None

    return check


def field_of(message: Any, path: str) -> Any:
    """The value at `a.b[2].c`; VerbError with the text of ros2cli."""
    value = message
    for step in _STEP.findall(path):
        try:
            value = value[int(step[1:-1])] if step.startswith("[") else getattr(value, step)
        except (AttributeError, IndexError, TypeError, ValueError) as error:
            raise VerbError(f"Invalid field '{path}': {error}", hint=_fields_of(value)) from None
    return value


def _fields_of(value: Any) -> str | None:
    if hasattr(value, "get_fields_and_field_types"):
        return f"fields: {', '.join(value.get_fields_and_field_types()) or 'none'}"
    return f"it has {len(value)} values: [0] is the first" if is_list(value) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Writer:
    """How messages are written; `prefixed` puts the topic before each line.

    Of a message `fields` are selected, the whole without; each is a value with its path.
    """

    style: Style
    csv: bool = False
    json: bool = False
    raw: bool = False
    info: bool = False
    fields: tuple[str, ...] = ()
    prefixed: bool = False

    def values(self, sample: ReceivedMessage) -> list[tuple[str, Any]]:
        """The selected fields, or the message with an empty path."""
        if not self.fields or self.raw:
            return [("", sample.message)]
        return [(path, field_of(sample.message, path)) for path in self.fields]

    def pieces(
        self, sample: ReceivedMessage, values: Sequence[tuple[str, object]]
    ) -> Iterator[str]:
        """What is printed for some of the `values`, in pieces: long arrays are not held as text."""
        if self.json:
            yield json_line(self._document(sample, values)) + "\n"
        elif self.prefixed:
            text = "".join(self._texts(sample, values))
            yield "".join(
                f"[{sample.topic}] {line}\n" for line in text.removesuffix("\n").split("\n")
            )
        else:
            yield from self._texts(sample, values)

    def _texts(
        self, sample: ReceivedMessage, values: Sequence[tuple[str, object]]
    ) -> Iterator[str]:
        if self.csv and not self.raw:
            for _, value in values:
                yield self._info(sample)
                yield from self._body(value)
            return
        yield self._info(sample)
        for _, value in values:
            yield from self._body(value)
        if not self.csv:
            yield "---\n"

    def _document(
        self, sample: ReceivedMessage, values: Sequence[tuple[str, Any]]
    ) -> dict[str, Any]:
        plain = {path: list(one) if self.raw else self._plain(one) for path, one in values}
        message = plain if len(self.fields) > 1 and not self.raw else next(iter(plain.values()))
        document = {"topic": sample.topic, "message": to_json_plain(message)}
        return {**document, "info": sample.info} if self.info else document

    def _plain(self, value: object) -> Any:
        if hasattr(value, "SLOT_TYPES"):
            return to_plain(value, self.style)
        if isinstance(value, bytes):
            return value.decode("latin-1")
        if hasattr(value, "tolist"):
            return value.tolist()
        if isinstance(value, list):
            return [self._plain(item) for item in value]
        return value

    def _info(self, sample: ReceivedMessage) -> str:
        if not self.info:
            return ""
        if self.raw:
            return f"---Got new message, message info:---\n{sample.info}\n---Message data:---\n"
        if self.csv:
            return "".join(f"{sample.info[name]}," for name in _INFO)
        return f"{dump(sample.info, sort=True)}---\n"

    def _body(self, value: object) -> Iterator[str]:
        if not hasattr(value, "SLOT_TYPES"):
            yield f"{value}\n"
        elif self.csv:
            yield f"{to_csv(value, self.style)}\n"
        else:
            yield from yaml_pieces(value, self.style)
