"""Inbox: requests on their way in."""

from __future__ import annotations

import json
import os
from typing import Any

from launcher.graph.errors import VerbError

READ_BYTES = 2**16


class Inbox:
    """Cuts what a descriptor gives into lines; `is_closed` when there will be no more."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._partial = b""
        self.is_closed = False

    def lines(self) -> list[bytes]:
        """The lines that have come; call it when there is something to read."""
        chunk = os.read(self._descriptor, READ_BYTES)
        self.is_closed = not chunk
        *lines, self._partial = (self._partial + chunk).split(b"\n")
        return [line for line in lines if line.strip()]


class Request:
    """One request. Its fields are asked for by name and kind; VerbError if one does not fit."""

    def __init__(self, line: bytes) -> None:
        self.id: Any = None
        try:
            fields = json.loads(line)
        except ValueError as error:
            raise VerbError(f"not a line of JSON: {error}") from None
        if not isinstance(fields, dict):
            raise VerbError("a request is a JSON object")
        self.id = fields.get("id")
        self._fields = fields

    @property
    def word(self) -> str:
        """What is to be done."""
        return str(self._fields.get("do"))

    def text(self, name: str) -> str:
        """A text that must be there."""
        value = self._fields.get(name)
        if not isinstance(value, str) or not value:
            raise VerbError(f"'{name}' must be a text, got {json.dumps(value)}")
        return value

    def optional_text(self, name: str) -> str | None:
        """A text, or None if it is missing or null."""
        return None if self._fields.get(name) is None else self.text(name)

    def number(self, name: str, default: float) -> float:
        """A number that is not negative."""
        value = self._fields.get(name)
        value = default if value is None else value
        if isinstance(value, bool) or not isinstance(value, int | float) or not value >= 0:
            raise VerbError(f"'{name}' must be a number, got {json.dumps(value)}")
        return float(value)

    def optional_number(self, name: str) -> float | None:
        """A number, or None if it is missing or null."""
        return None if self._fields.get(name) is None else self.number(name, 0.0)

    def flag(self, name: str, default: bool) -> bool:
        """True or false."""
        value = self._fields.get(name, default)
        if not isinstance(value, bool):
            raise VerbError(f"'{name}' must be true or false, got {json.dumps(value)}")
        return value

    def mapping(self, name: str) -> dict[str, Any] | None:
        """An object, or None if it is missing or null."""
        value = self._fields.get(name)
        if value is not None and not isinstance(value, dict):
            raise VerbError(f"'{name}' must be an object, got {json.dumps(value)}")
        return value

    def names(self, name: str) -> list[str] | None:
        """A list of texts, or None if it is missing or null."""
        value = self._fields.get(name)
        if value is None:
            return None
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise VerbError(f"'{name}' must be a list of texts, got {json.dumps(value)}")
        return value

    def values(self) -> dict[str, Any]:
        """`values`: the fields of a message, as an object or as YAML."""
        from launcher.graph.from_yaml import parse

        if isinstance(self._fields.get("values"), str):
            return parse(self._fields["values"])
        return self.mapping("values") or {}
