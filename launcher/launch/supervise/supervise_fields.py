"""The entries of a process in a supervision file: one table for the reader, schema and docs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from launcher.base.document.fields import (
    Field,
    FieldError,
    FieldType,
    choice,
    parsed_entries,
    properties_of,
    raise_all,
    shown,
)
from launcher.base.document.quantities import DURATION
from launcher.base.model.supervision import ON_TIMEOUT, After
from launcher.launch import process_options
from launcher.launch.supervise import fault_fields
from launcher.launch.supervise.ready_fields import TEXTS, facts, facts_schema, is_text
from launcher.run.monitor.budget_parser import KEYS as BUDGET_KEYS

_SCALAR = {"type": ["string", "number"]}


def _scalar(name: str, read: Callable[[str], Any], example: str = "") -> FieldType:
    """One value, which `read` takes as a text."""

    def parse(value: object) -> Any:
        if not isinstance(value, str):
            raise FieldError(f"'{name}' takes one value")
        try:
            return read(value)
        except ValueError as error:
            text = f"invalid value {shown(value)} for '{name}'"
            if not example:
                raise FieldError(text, hint=str(error)) from None
            raise FieldError(f"{text}: {error}", hint=f"as in {example}") from None

    return FieldType(parse, _SCALAR)


def _names(value: object) -> tuple[str, ...]:
    names = value if isinstance(value, list) else [value]
    bad = [index for index, one in enumerate(names) if not is_text(one)]
    raise_all(
        [
            FieldError(
                f"{shown(names[index])} is not the name of a process",
                (index,) if isinstance(value, list) else (),
                "a name or a pattern, as in dispatcher or robot_*",
            )
            for index in bad
        ]
    )
    return tuple(names)


NAMES = FieldType(_names, TEXTS)
AFTER_ENTRIES = {
    "processes": (NAMES, "names or patterns of the processes that it waits for"),
    "timeout": (DURATION, "how long it waits at most (default: 60 s)"),
    "on_timeout": (choice(*ON_TIMEOUT), "what happens then (default: start)"),
}


def _after(value: object) -> After:
    """Names, or a mapping with them, the timeout and its consequence."""
    if not isinstance(value, Mapping):
        return After(names=_names(value))
    known = {name: type_ for name, (type_, _) in AFTER_ENTRIES.items()}
    found, errors = parsed_entries(value, known, "'after'")
    if "processes" not in found and not errors:
        errors.append(FieldError("'after' needs 'processes'", hint="as in {processes: dispatcher}"))
    raise_all(errors)
    fields = {"processes": "names", "timeout": "timeout_s", "on_timeout": "on_timeout"}
    return After(**{fields[key]: one for key, one in found.items()})


_AFTER_SCHEMA = {
    "anyOf": [
        *TEXTS["anyOf"],
        {
            "type": "object",
            "additionalProperties": False,
            "required": ["processes"],
            "properties": {
                name: {**type_.schema, "description": doc}
                for name, (type_, doc) in AFTER_ENTRIES.items()
            },
        },
    ]
}

# Entries that are options of the same name; the field of RunOptions, and the parser of the value.
SETTINGS: dict[str, tuple[str, Callable[[str], Any], str, str]] = {
    "restart": (
        "restart",
        process_options.restart_policy,
        "on-failure,max=5,window=60,backoff=0.5..30",
        "how it is restarted, as `--restart`",
    ),
    "stop": (
        "stop",
        process_options.stop_policy,
        "int:2,term:1",
        "the signals that stop it, as `--stop`",
    ),
    "nice": ("limits", process_options.niceness, "5", "niceness, as `--nice`"),
    "cpus": ("limits", process_options.processors, "0-1", "processors, as `--cpus`"),
    "limit": (
        "limits",
        process_options.resource_limits,
        "nofile=256,as=1G,core=0",
        "resource limits, as `--limit`",
    ),
}
_BUDGET_DOCS = {
    "cpu": "percent of one core that it may use, as in 80%",
    "memory": "memory (USS) that it may use, as in 200M",
    "threads": "threads that it may have",
    "fds": "files that it may have open",
    "for": "seconds above a limit until `action` is due (default: 10)",
    "action": "what happens then: warn (the default), restart or stop-run",
}

START_FIELDS = (
    Field("ready_when", FieldType(facts, facts_schema()), "facts with which it is ready"),
    Field("after", FieldType(_after, _AFTER_SCHEMA), "its first start waits until these are ready"),
    Field("restart_with", NAMES, "it is restarted when one of these has been restarted"),
)
FIELDS = (
    *START_FIELDS,
    *(
        Field(name, _scalar(name, read, example), doc)
        for name, (_, read, example, doc) in SETTINGS.items()
    ),
    *(
        Field(name, _scalar(name, read), _BUDGET_DOCS[name])
        for name, (_, read) in BUDGET_KEYS.items()
    ),
)


def json_schema() -> dict[str, Any]:
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Supervision of the processes of a launch file",
        "type": ["object", "null"],
        "propertyNames": {"minLength": 1},
        "properties": {fault_fields.ON: fault_fields.schema()},
        "additionalProperties": {"$ref": "#/$defs/process"},
        "$defs": {
            "process": {
                "description": "the processes that the name or pattern matches",
                "type": "object",
                "additionalProperties": False,
                "properties": properties_of(FIELDS),
            }
        },
    }
