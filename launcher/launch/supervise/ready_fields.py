"""The facts of `ready_when`: one table for the reader, the schema and the docs."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from launcher.base.document.fields import (
    FieldError,
    FieldType,
    choice,
    near,
    nested,
    parsed_entries,
    raise_all,
    shown,
)
from launcher.base.document.quantities import DURATION
from launcher.base.model.supervision import Fact
from launcher.output.filters import Pattern

STATES = ("unconfigured", "inactive", "active", "finalized")
_PLACEHOLDERS = r"\{(?:name|node|namespace)\}"
_NAME = rf"(?:/|{_PLACEHOLDERS})(?:[A-Za-z0-9_/~]|{_PLACEHOLDERS})*"
_NODE_PATTERN = rf"\*|{_NAME[:-2]}|[*?\[\]])*"
_TYPE = r"[A-Za-z][A-Za-z0-9_]*/{kind}/[A-Za-z][A-Za-z0-9_]*"
MIN_EVERY_S = 0.05
# The schema of a text, or a list of them.
TEXTS = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}


def is_text(value: object) -> bool:
    return isinstance(value, str) and bool(value.strip()) and "\0" not in value


def matching(noun: str, pattern: str, example: str) -> FieldType:
    def parse(value: object) -> str:
        if not isinstance(value, str) or re.fullmatch(pattern, value, re.ASCII) is None:
            raise FieldError(f"{shown(value)} is not {noun}", hint=f"as in {example}")
        return value

    return FieldType(parse, {"type": "string", "pattern": f"^(?:{pattern})$"})


def _regex(value: object) -> str:
    if not is_text(value):
        raise FieldError(f"{shown(value)} is not a regular expression", hint="as in 'is ready$'")
    assert isinstance(value, str)
    try:
        Pattern(value)
    except (re.error, ValueError, OverflowError, RecursionError) as error:
        raise FieldError(f"invalid regular expression {shown(value)}: {error}") from None
    return value


def _address(value: object) -> str:
    """`ADDRESS:PORT`; names are not looked up, since the launcher would have to wait for that."""
    hint = "as in 8080, 10.0.0.2:8080 or [fd00::2]:8080"
    host, _, port = value.rpartition(":") if isinstance(value, str) else ("", "", "")
    if not (port.isascii() and port.isdecimal()) or not 0 < int(port[:6]) < 65536:
        raise FieldError(f"{shown(value)} is not a TCP port", hint=hint)
    host = host.removeprefix("[").removesuffix("]")
    if host in ("", "localhost"):
        return f"127.0.0.1:{int(port)}"
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        raise FieldError(f"'{host}' is not an IP address", hint=hint) from None
    return f"[{address}]:{int(port)}" if address.version == 6 else f"{address}:{int(port)}"


def words(value: object) -> tuple[str, ...]:
    """A command: a text for a shell, or a list of words."""
    hint = "as in 'curl -sf localhost:8080/health', or [curl, -sf, ...]"
    if is_text(value):
        return ("/bin/sh", "-c", str(value))
    if not isinstance(value, list) or not value or not all(map(is_text, value)):
        raise FieldError(f"{shown(value)} is not a command", hint=hint)
    return tuple(value)


def _every(value: object) -> float:
    every_s: float = DURATION.parse(value)
    if every_s < MIN_EVERY_S:
        raise FieldError(f"{shown(value)} is too often: at least {MIN_EVERY_S:g} s")
    return every_s


def _flag(value: object) -> bool:
    if value not in ("true", "false"):
        raise FieldError(f"{shown(value)} is not true or false")
    return value == "true"


def _request(value: object) -> dict[str, object]:
    if not isinstance(value, Mapping):
        raise FieldError(f"{shown(value)} is not a request", hint="as in {data: true}")
    return {str(key): _typed(one, 0) for key, one in value.items()}


def _typed(value: object, depth: int) -> object:
    """Texts as the values that they are in YAML: the document was read without types."""
    if depth > 20:
        raise FieldError("a request is nested too deeply")
    if isinstance(value, Mapping):
        return {str(key): _typed(one, depth + 1) for key, one in value.items()}
    if isinstance(value, list):
        return [_typed(one, depth + 1) for one in value]
    if isinstance(value, str):
        import yaml

        from launcher.base import yaml_bounds

        try:
            return yaml_bounds.load(value) if value else value
        except yaml.YAMLError:
            return value
    return value


def _exit_code(value: object) -> str:
    if not isinstance(value, str) or not value.isdecimal() or int(value[:4]) > 255:
        raise FieldError(f"{shown(value)} is not an exit code", hint="as in 0")
    return str(int(value))


TOPIC = matching("the full name of a topic", _NAME, "/fleet/tasks or /{name}/status")
SERVICE = matching("the full name of a service", _NAME, "/fleet/pause or {node}/get_parameters")
NODE = matching("the full name of a node", _NODE_PATTERN, "/dispatcher, /robot_1/** or '*'")
_NODE_ENTRY = "node that has it: a pattern, '*' for any (default: the node of the process)"
_SCALAR = {"type": ["string", "number"]}


class FactKind(NamedTuple):
    """A kind of fact; its value is the `subject`, or a mapping with it under `key` and entries.

    `names` are the fields of `Fact` that the entries set.
    """

    name: str
    doc: str
    subject: FieldType
    key: str = ""
    entries: Mapping[str, tuple[FieldType, str]] = {}
    names: Mapping[str, str] = {}

    def parse(self, value: object) -> Fact:
        if self.key and isinstance(value, Mapping):
            return self._long(value)
        return self._fact(self.subject.parse(value), {})

    def _long(self, value: Mapping[object, object]) -> Fact:
        known = {
            self.key: self.subject,
            **{name: type_ for name, (type_, _) in self.entries.items()},
        }
        found, errors = parsed_entries(value, known, f"'{self.name}'")
        if self.key not in found and not errors:
            errors.append(FieldError(f"'{self.name}' needs '{self.key}'"))
        raise_all(errors)
        return self._fact(found.pop(self.key), found)

    def _fact(self, subject: Any, more: Mapping[str, Any]) -> Fact:
        given = {self.names.get(name, name): value for name, value in more.items()}
        if self.name == "command":
            text = subject[2] if subject[:2] == ("/bin/sh", "-c") else " ".join(subject)
            return Fact(kind=self.name, subject=text, words=subject, **given)
        return Fact(kind=self.name, subject=str(subject), **given)

    @property
    def schema(self) -> dict[str, object]:
        short = dict(self.subject.schema)
        if not self.key:
            return {**short, "description": self.doc}
        entries = {
            name: {**type_.schema, "description": doc}
            for name, (type_, doc) in self.entries.items()
        }
        long = {
            "type": "object",
            "additionalProperties": False,
            "required": [self.key],
            "properties": {self.key: short, **entries},
        }
        return {"anyOf": [short, long], "description": self.doc}


_OF = {"node": (NODE, _NODE_ENTRY)}
_EVERY = FieldType(_every, DURATION.schema)
_FLAG = FieldType(_flag, {"type": "boolean"})

KINDS = (
    FactKind("node", "The node is in the graph (full name or pattern).", NODE),
    FactKind("publisher", "The node publishes a topic.", TOPIC, "topic", _OF),
    FactKind("subscription", "The node subscribes to a topic.", TOPIC, "topic", _OF),
    FactKind(
        "message",
        "A message has been received on a topic that the node publishes.",
        TOPIC,
        "topic",
        {
            "type": (
                matching("a message type", _TYPE.format(kind="msg"), "std_msgs/msg/String"),
                "message type (default: that of the publisher)",
            ),
            **_OF,
        },
    ),
    FactKind(
        "service",
        "A service has answered a call.",
        SERVICE,
        "name",
        {
            "type": (
                matching("a service type", _TYPE.format(kind="srv"), "std_srvs/srv/Trigger"),
                "service type (default: as it is offered)",
            ),
            "request": (FieldType(_request, {"type": "object"}), "fields of the request"),
            "call": (_FLAG, "false: it only has to be there, and is never called"),
        },
    ),
    FactKind(
        "lifecycle",
        "The lifecycle node is in a state.",
        choice(*STATES),
        "state",
        {"node": (NODE, "full name of the node (default: that of the process)")},
    ),
    FactKind(
        "log",
        "The process has printed a line in which a regular expression is found.",
        FieldType(_regex, {"type": "string", "minLength": 1, "format": "regex"}),
    ),
    FactKind(
        "port",
        "A TCP connection to a port of this machine, or to ADDRESS:PORT, is accepted.",
        FieldType(_address, _SCALAR),
        "address",
        {"every": (_EVERY, "time from one attempt to the next (default: 1 s)")},
        {"every": "every_s"},
    ),
    FactKind(
        "command",
        "A command exits with code 0; it is repeated until then.",
        FieldType(words, TEXTS),
        "run",
        {"every": (_EVERY, "time from one attempt to the next (default: 1 s)")},
        {"every": "every_s"},
    ),
    FactKind(
        "exit",
        "The process has exited with this code: others wait for what it does to be done.",
        FieldType(_exit_code, {"type": "integer", "minimum": 0, "maximum": 255}),
    ),
)
BY_NAME = {kind.name: kind for kind in KINDS}


def facts(value: object) -> tuple[Fact, ...]:
    """The facts of a mapping, or of a list of mappings, all of which have to hold."""
    parts = value if isinstance(value, list) else [value]
    found: list[Fact] = []
    errors: list[FieldError] = []
    for index, part in enumerate(parts):
        path = (index,) if isinstance(value, list) else ()
        if not isinstance(part, Mapping) or not part:
            hint = "as in {publisher: /fleet/tasks}"
            errors.append(FieldError(f"{shown(part)} is not a fact", path, hint))
            continue
        for key, one in part.items():
            if key not in BY_NAME:
                text = f"unknown kind of fact '{key}'"
                errors.append(FieldError(text, (*path, key), near(key, BY_NAME), key=True))
                continue
            try:
                found.append(nested(BY_NAME[str(key)].parse, one, *path, key))
            except FieldError as error:
                errors += error.all
    raise_all(errors)
    return tuple(found)


def facts_schema() -> dict[str, object]:
    one = {
        "type": "object",
        "minProperties": 1,
        "additionalProperties": False,
        "properties": {kind.name: kind.schema for kind in KINDS},
    }
    return {"anyOf": [one, {"type": "array", "items": one}]}
