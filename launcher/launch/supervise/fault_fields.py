"""The entries of `on:` in a supervision file: what is done when a fault is confirmed or healed."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from launcher.base.document.fields import (
    Field,
    FieldError,
    FieldType,
    choice,
    mapping_schema,
    near,
    nested,
    raise_all,
    shown,
)
from launcher.base.document.quantities import DURATION, DURATION_PATTERN, for_editors
from launcher.base.model.fault_action import WHEN
from launcher.launch.supervise.ready_fields import TEXTS, is_text
from launcher.launch.supervise.ready_fields import words as command_words

ON = "on"  # a text, since the document is read without types: in YAML 1.1 it is also `true`
EXAMPLE = "as in {fault: robot_2 reports, do: restart robot_2}"
MAX_WITHIN_S = 600.0
MAX_TIMES = 1000
_BUDGET = rf"(?P<times>[0-9]+) +(?:per|in) +{DURATION_PATTERN}"
_HEADER = re.compile(r"[!#$%&'*+.^_`|~0-9A-Za-z-]+", re.ASCII)
_VARIABLE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*", re.ASCII)
_TEXT = {"type": "string", "minLength": 1}


def _pattern(value: object) -> str:
    if not is_text(value):
        hint = "a name as in `faults`, or a pattern; with ': ' in it, it needs quotes"
        raise FieldError(f"{shown(value)} is not the name of a fault", hint=hint)
    assert isinstance(value, str)
    return value


def _names(value: object) -> tuple[str, ...]:
    names = value if isinstance(value, list) else value.split() if isinstance(value, str) else []
    wrong = [index for index, one in enumerate(names) if not is_text(one)]
    hint = "as in restart robot_1 robot_2"
    raise_all([FieldError(f"{shown(names[i])} is not a process", (i,), hint) for i in wrong])
    if not names:
        raise FieldError("it needs the name of a process, or a pattern", hint=hint)
    return tuple(names)


def _url(value: object) -> str:
    """An address, or `$NAME`."""
    if isinstance(value, str) and value[:1] == "$" and _VARIABLE.fullmatch(value[1:]):
        return value
    if not isinstance(value, str) or not is_url(value):
        hint = "as in https://example.com/hook, or $NAME of the environment; no user or password"
        raise FieldError("expected an address of http or https", hint=hint)
    return value


def is_url(text: str) -> bool:
    """Whether a webhook can be sent to it."""
    from urllib.parse import urlsplit

    if not text.isascii() or not text.isprintable() or " " in text:
        return False
    try:
        parts = urlsplit(text)
        _ = parts.port  # ValueError if it is none
    except ValueError:
        return False
    is_known = parts.scheme in ("http", "https")
    return is_known and bool(parts.hostname) and parts.username is None and parts.password is None


def _nothing(value: object) -> None:
    if value not in (None, ""):
        raise FieldError(f"{shown(value)} is too much: it takes nothing")


# Action -> the field of FaultAction that has its value, the parser, the schema, its default budget.
_FEW, _MORE = (3, 600.0), (20, 600.0)
ACTIONS: dict[str, tuple[str, Callable[[object], Any], Mapping[str, object], tuple[int, float]]] = {
    "restart": ("names", _names, TEXTS, _FEW),
    "stop": ("names", _names, TEXTS, _FEW),
    "start": ("names", _names, TEXTS, _FEW),
    "snapshot": ("", _nothing, {"type": "null"}, _MORE),
    "run": ("words", command_words, TEXTS, _MORE),
    "webhook": ("url", _url, _TEXT, _MORE),
    "desktop": ("", _nothing, {"type": "null"}, _MORE),
}


def _do(value: object) -> dict[str, Any]:
    """`restart robot_1`, or {restart: [robot_1]}: fields of FaultAction."""
    if isinstance(value, Mapping) and len(value) == 1:
        ((name, subject),) = value.items()
        return _action(name, subject, (name,))
    if not is_text(value):
        text = f"{shown(value)} is not an action"
        raise FieldError(text, hint="as in restart robot_1, or {run: [date, -u]}")
    name, _, rest = str(value).strip().partition(" ")
    return _action(name, rest.strip(), ())


def _action(name: object, subject: object, path: tuple[object, ...]) -> dict[str, Any]:
    if name not in ACTIONS:
        hint = near(name, ACTIONS)
        raise FieldError(f"unknown action {shown(name)}", path, hint, key=bool(path))
    field, parse, _, (times, period_s) = ACTIONS[str(name)]
    try:
        found = nested(parse, subject, *path)
    except FieldError as error:
        for one in error.all:
            one.args = (f"'{name}': {one}",)
        raise
    fields = {"kind": name, "times": times, "period_s": period_s}
    return {**fields, field: found} if field else fields


def _within(value: object) -> float:
    within_s: float = DURATION.parse(value)
    if not 0 < within_s <= MAX_WITHIN_S:
        raise FieldError(f"{shown(value)} is not a time limit above 0, of at most 10 min")
    return within_s


def _at_most(value: object) -> tuple[int, float]:
    found = re.fullmatch(_BUDGET, value) if isinstance(value, str) else None
    if found is None:
        raise FieldError(f"{shown(value)} is not a budget", hint="as in 3 per 10 min")
    times = int(found["times"][:6])
    period_s: float = DURATION.parse(value[found.start("number") :])  # type: ignore[index]
    if not 0 < times <= MAX_TIMES or period_s <= 0:
        raise FieldError(f"{shown(value)} is not a budget: from 1 to {MAX_TIMES} in a time")
    return times, period_s


def _headers(value: object) -> tuple[tuple[str, str], ...]:
    if not isinstance(value, Mapping) or not value:
        raise FieldError("expected names of headers and of variables", hint=_HEADERS_HINT)
    errors = []
    for name, variable in value.items():
        if not isinstance(name, str) or not _HEADER.fullmatch(name):
            text = f"{shown(name)} is not the name of a header"
            errors.append(FieldError(text, (name,), key=True))
        elif not isinstance(variable, str) or not _VARIABLE.fullmatch(variable):
            text = f"'{name}' takes the name of an environment variable, which has its value"
            errors.append(FieldError(text, (name,), _HEADERS_HINT, key=True))
    raise_all(errors)
    return tuple(value.items())


_HEADERS_HINT = "as in {Authorization: FLEET_TOKEN}, for FLEET_TOKEN of the environment"

FIELDS = (
    Field("fault", FieldType(_pattern, _TEXT), "name or pattern of faults", required=True),
    Field(
        "do",
        FieldType(
            _do,
            {
                "anyOf": [
                    {"type": "string", "pattern": rf"^\s*(?:{'|'.join(ACTIONS)})(?:\s|$)"},
                    *(
                        {
                            "type": "object",
                            "required": [name],
                            "additionalProperties": False,
                            "properties": {name: dict(schema)},
                        }
                        for name, (_, _, schema, _) in ACTIONS.items()
                    ),
                ]
            },
        ),
        "restart NAME, stop NAME, start NAME, snapshot, run COMMAND, webhook URL or desktop",
        required=True,
    ),
    Field("when", choice(*WHEN), "when it is done (default: confirmed)"),
    Field("within", FieldType(_within, DURATION.schema), "how long it may take (default: 10 s)"),
    Field(
        "at_most",
        FieldType(_at_most, {"type": "string", "pattern": f"^(?:{for_editors(_BUDGET)})$"}),
        "how often it is done (default: 3 per 10 min of processes, else 20 per 10 min)",
    ),
    Field(
        "headers",
        FieldType(_headers, {"type": "object", "additionalProperties": _TEXT, "minProperties": 1}),
        "of a webhook: each with the environment variable that has its value",
    ),
)


def schema() -> dict[str, Any]:
    """The JSON Schema of the value of `on`: one entry, or several."""
    one = mapping_schema(FIELDS)
    description = "what is done when faults of a watched run are confirmed or healed"
    return {"description": description, "anyOf": [one, {"type": "array", "items": one}]}
