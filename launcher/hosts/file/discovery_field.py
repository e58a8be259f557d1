"""The entry `discovery` of a hosts file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from launcher.base.document.fields import FieldError, FieldType, near, nested, raise_all
from launcher.base.text import did_you_mean
from launcher.hosts.file.hosts_model import LOCAL, Discovery, DiscoveryMode

MODES = tuple(mode.value for mode in DiscoveryMode)
_KEYS = ("mode", "server", "backup", "port")
_OF_SERVER = _KEYS[1:]


def _parse(value: object) -> Discovery:
    if isinstance(value, str):
        return Discovery(mode=_mode(value))
    if not isinstance(value, Mapping):
        hint = "as in peers, or {mode: server, server: bot1}"
        raise FieldError(f"expected one of {', '.join(MODES)}, or a mapping", hint=hint)
    errors: list[FieldError] = []
    found: dict[str, Any] = {}
    for key, one in value.items():
        try:
            if key not in _KEYS:
                message = f"'discovery' has no '{key}'"
                raise FieldError(message, (key,), near(key, _KEYS), key=True)
            found[key] = nested(_READ[key], one, key)
        except FieldError as error:
            errors.append(error)
    if "mode" not in value and not errors:
        errors.append(FieldError("'discovery' needs 'mode'", hint=f"one of {', '.join(MODES)}"))
    for key in _OF_SERVER:
        if key in found and found.get("mode", DiscoveryMode.SERVER) is not DiscoveryMode.SERVER:
            errors.append(FieldError(f"'{key}' needs the mode 'server'", (key,), key=True))
    backup = found.get("backup")
    if not errors and backup is not None and backup == found.get("server", LOCAL):
        message = f"'server' and 'backup' are on the same host, '{backup}', and would fail together"
        hint = "name another host, or leave 'backup' out"
        errors.append(FieldError(message, ("backup",), hint))
    raise_all(errors)
    return Discovery(**found)


def _mode(value: object) -> DiscoveryMode:
    if value not in MODES:
        shown = f"'{value}'" if isinstance(value, str) else "this"
        hint = did_you_mean(str(value), MODES)
        raise FieldError(f"{shown} is not one of {', '.join(MODES)}", hint=hint)
    return DiscoveryMode(value)


def _host(value: object) -> str:
    if not isinstance(value, str) or not value:
        raise FieldError("expected the name of a host", hint=f"a name of 'hosts', or {LOCAL}")
    return value


def _port(value: object) -> int:
    is_number = isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 6
    if not is_number or not 0 < int(str(value)) < 65536:
        raise FieldError("this is not a port: expected 1 to 65535")
    return int(str(value))


_READ = {"mode": _mode, "server": _host, "backup": _host, "port": _port}
_NAME = {"type": "string", "minLength": 1}
DISCOVERY = FieldType(
    _parse,
    {
        "anyOf": [
            {"enum": list(MODES)},
            {
                "type": "object",
                "additionalProperties": False,
                "required": ["mode"],
                "properties": {
                    "mode": {"enum": list(MODES)},
                    "server": {**_NAME, "description": "where the discovery server runs"},
                    "backup": {**_NAME, "description": "where a second one runs"},
                    "port": {"type": "integer", "minimum": 1, "maximum": 65535},
                },
            },
        ]
    },
)
