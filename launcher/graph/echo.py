"""Echo: prints the messages of topics, in the shapes of `ros2 topic echo`."""

from __future__ import annotations

import json
from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from launcher.errors import UsageError
from launcher.graph.errors import VerbError
from launcher.graph.listener import Sample
from launcher.graph.to_yaml import Style, dump, to_csv, to_json_plain, to_plain, to_yaml

Check = Callable[[Any], bool]


def compiled_filter(expression: str | None) -> Check | None:
    """A check of a message `m`; UsageError if the expression is no Python."""
    if expression is None:
        return None
    try:
        code = compile(expression, "--filter", "eval")
    except SyntaxError as error:
        raise UsageError(f"--filter is not a Python expression: {error.msg}") from None

    def check(message: Any) -> bool:
        try:
            return bool(eval(code, {"m": message}))  # the user's own expression, as with ros2cli
        except Exception as error:
            text = f"{type(error).__name__}: {error}"
            raise VerbError(f"--filter failed: {text}", hint="the message is called m") from None

    return check


def field_of(message: Any, path: str) -> Any:
    """The value at `a.b.c`; VerbError as ros2cli words it."""
    value = message
    for name in path.split("."):
        try:
            value = getattr(value, name)
        except AttributeError as error:
            raise VerbError(f"Invalid field '{path}': {error}") from None
    return value


@dataclass(frozen=True, slots=True, kw_only=True)
class Writer:
    """How messages are written; `prefixed` puts the topic before each line."""

    style: Style
    csv: bool = False
    json: bool = False
    raw: bool = False
    info: bool = False
    field: str | None = None
    prefixed: bool = False

    @classmethod
    def of(cls, options: Namespace) -> Writer:
        """From the options of `topic echo`."""
        length = None if options.full_length or options.json else options.truncate_length
        style = Style(
            length=length, no_arr=options.no_arr, no_str=options.no_str, flow=options.flow_style
        )
        return cls(
            style=style,
            csv=options.csv,
            json=options.json,
            raw=options.raw,
            info=options.include_message_info,
            field=options.field,
            prefixed=len(options.topic_names) > 1,
        )

    def text(self, sample: Sample) -> str:
        """What is printed for a message, with its line end."""
        value = sample.message
        if self.field is not None and not self.raw:
            value = field_of(value, self.field)
        if self.json:
            return json.dumps(self._document(sample, value), ensure_ascii=False) + "\n"
        text = self._info(sample) + self._body(value)
        if not self.prefixed:
            return text
        return "".join(f"[{sample.topic}] {line}\n" for line in text.splitlines())

    def _document(self, sample: Sample, value: Any) -> dict[str, Any]:
        message = list(value) if self.raw else self._plain(value)
        document = {"topic": sample.topic, "message": to_json_plain(message)}
        return {**document, "info": sample.info} if self.info else document

    def _plain(self, value: Any) -> Any:
        if hasattr(value, "SLOT_TYPES"):
            return to_plain(value, self.style)
        if isinstance(value, bytes):
            return value.decode("latin-1")
        if hasattr(value, "tolist"):
            return value.tolist()
        if isinstance(value, list):
            return [self._plain(item) for item in value]
        return value

    def _info(self, sample: Sample) -> str:
        return f"{dump(sample.info, sort=True)}---\n" if self.info else ""

    def _body(self, value: Any) -> str:
        if not hasattr(value, "SLOT_TYPES"):
            return f"{value}\n" if self.csv else f"{value}\n---\n"
        if self.csv:
            return f"{to_csv(value, self.style)}\n"
        return f"{to_yaml(value, self.style)}---\n"
