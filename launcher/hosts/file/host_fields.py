"""The entries of a host in a hosts file: one table for the reader, the schema and the docs."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Callable, Mapping
from typing import TypeVar

from launcher.base.document.fields import (
    Field,
    FieldError,
    FieldType,
    choice,
    near,
    nested,
    raise_all,
)
from launcher.base.document.quantities import DURATION, DURATION_PATTERN, for_editors
from launcher.hosts.file.hosts_model import HostEngine, LinkPolicy, Secret
from launcher.hosts.file.ssh_options import SSH_OPTIONS

T = TypeVar("T")
_SCALAR = {"type": ["string", "number", "boolean"]}
HOST_NAME = r"[A-Za-z0-9][A-Za-z0-9_.-]*"
NOT_DEFAULT = ("address",)  # what `defaults` cannot have
_LABEL = r"[A-Za-z0-9_](?:[A-Za-z0-9_-]{0,61}[A-Za-z0-9_])?"
_HOST_NAME = re.compile(rf"{_LABEL}(?:\.{_LABEL})*\.?")
_USER = r"[A-Za-z_][A-Za-z0-9_.-]*\$?"
_VARIABLE = r"[A-Za-z_][A-Za-z0-9_]*"
_MAX_HOST_NAME = 253
_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*://")


def _address(value: object) -> str:
    if not isinstance(value, str) or not value:
        raise FieldError("expected an address, as in 10.0.0.2, robot.local or fd00::2")
    url = _URL.match(value)
    rest = value[url.end() :].partition("/")[0] if url else value
    user, at, rest = rest.rpartition("@")
    name, colon, port = _split_port(rest)
    if url or at or colon:
        what = "has a user in the address" if at else "has a port in the address"
        if url:
            what = "is a URL: only the name or the address stands here"
        raise _too_much(f"'{value}' {what}", name, user, port)
    if value.startswith("["):
        raise FieldError(f"'{value}' has brackets: an IPv6 address stands without them here")
    if value.count(":") > 1:
        return _ip_address(value, ipaddress.IPv6Address)
    if re.fullmatch(r"[0-9.]+", value):
        return _ip_address(value, ipaddress.IPv4Address)
    if len(value) > _MAX_HOST_NAME or _HOST_NAME.fullmatch(value) is None:
        raise FieldError(f"'{value}' is not a host name or an IP address")
    return value


def _split_port(text: str) -> tuple[str, str, str]:
    """(name, `:` or nothing, port); an IPv6 address has a port only behind brackets."""
    in_brackets = re.fullmatch(r"\[(.*)\](:?)(.*)", text)
    if in_brackets:
        return in_brackets[1], in_brackets[2], in_brackets[3]
    return text.partition(":") if text.count(":") == 1 else (text, "", "")


def _too_much(message: str, name: str, user: str, port: str) -> FieldError:
    """The mistake of an address that contains entries with separate keys."""
    user = user.partition(":")[0]  # without a password
    entries = [f"'address: {name or '...'}'"]
    entries += [f"'user: {user}'"] if user else []
    entries += [f"'ssh: {{Port: {port}}}'"] if port.isdecimal() else []
    known = "" if user or port else "; `user` and `ssh: {Port: ...}` are separate keys"
    hint = f"write {', '.join(entries[:-1])}{' and ' if entries[1:] else ''}{entries[-1]}{known}"
    return FieldError(message, hint=hint)


def _ip_address(value: str, kind: Callable[[str], object]) -> str:
    try:
        kind(value)
    except ValueError as error:
        raise FieldError(f"'{value}' is not an IP address: {error}") from None
    return value


def _matching(noun: str, pattern: str, example: str) -> FieldType:
    def parse(value: object) -> str:
        if not isinstance(value, str) or re.fullmatch(pattern, value, re.ASCII) is None:
            shown = f"'{value}'" if isinstance(value, str) else "this"
            raise FieldError(f"{shown} is not {noun}: expected one such as {example}")
        return value

    return FieldType(parse, {"type": "string", "pattern": f"^{for_editors(pattern)}$"})


def remote_path(value: object) -> str:
    """A path on a host, relative to the home there if it begins with `~/`."""
    if not isinstance(value, str) or not value.strip():
        raise FieldError("expected a path on the host")
    if any(not char.isprintable() for char in value):
        raise FieldError("a path on the host has a control character")
    path = value.removeprefix("~/").lstrip("/") if value.startswith("~/") else value
    if not path or path[0] in "~-":
        hint = "paths are absolute, or relative to the home of the user there"
        raise FieldError(f"'{value}' is not a path that the host can use", hint=hint)
    return path


def _setup(value: object) -> tuple[str, ...]:
    if isinstance(value, list):
        return tuple(nested(_setup_file, one, number) for number, one in enumerate(value))
    return (_setup_file(value),)


def _setup_file(value: object) -> str:
    path = remote_path(value)
    stem, dot, suffix = path.rpartition(".")
    if suffix in ("bash", "zsh", "fish"):
        message = f"'{path}' needs {suffix}, and a POSIX shell reads it"
        raise FieldError(message, hint=f"use {stem}{dot}sh")
    return path


_STOP_AFTER = re.compile(r"(?:stop-after *= *)?(.+)")
_LEAST_STOP_AFTER_S = 1.0  # a beat may come late: `hosts/engine/link` sends four in this time


def _on_link_loss(value: object) -> LinkPolicy:
    if value == "keep":
        return LinkPolicy()
    found = _STOP_AFTER.fullmatch(value) if isinstance(value, str) else None
    try:
        stop_after_s = DURATION.parse(found[1] if found else value)
    except ValueError:
        shown = f"'{value}'" if isinstance(value, str) else "this"
        message = f"{shown} is not keep, or stop-after= with a time, as in stop-after=10 s"
        hint = near(value, ["keep", "stop-after=10 s"])
        raise FieldError(message, hint=hint if "did you" in str(hint) else None) from None
    if stop_after_s < _LEAST_STOP_AFTER_S:
        raise FieldError(f"'{value}' is too short: at least {_LEAST_STOP_AFTER_S:g} s")
    return LinkPolicy(stop_after_s=stop_after_s)


def _variables(value: object) -> dict[str, str | Secret]:
    return _mapping(value, "variables by name, as in {ROS_DOMAIN_ID: 7}", _VARIABLE, _variable)


def _variable(value: object) -> str | Secret:
    if isinstance(value, str):
        return _plain_text(value)
    if isinstance(value, Mapping) and len(value) == 1:
        ((key, name),) = value.items()
        if key not in ("from_environment", "from_file"):
            hint = "known: from_environment, from_file"
            raise FieldError(f"unknown source '{key}'", (key,), hint, key=True)
        if not isinstance(name, str) or not name or "\0" in name:
            raise FieldError(f"'{key}' needs a name", (key,))
        return Secret(variable=name) if key == "from_environment" else Secret(file=name)
    hint = "as in 7, {from_environment: FLEET_TOKEN} or {from_file: ~/.config/fleet.token}"
    raise FieldError("expected the value of a variable", hint=hint)


def _plain_text(value: object) -> str:
    if not isinstance(value, str) or "\0" in value:
        raise FieldError("expected a text")
    return value


def _labels(value: object) -> dict[str, str]:
    return _mapping(value, "labels of a node, as in {robot: bot1}", r"\S+", _plain_text)


def _mapping(
    value: object, expected: str, key_pattern: str, parse: Callable[[object], T]
) -> dict[str, T]:
    if not isinstance(value, Mapping):
        raise FieldError(f"expected {expected}")
    found: dict[str, T] = {}
    errors: list[FieldError] = []
    for key, one in value.items():
        try:
            if re.fullmatch(key_pattern, str(key), re.ASCII) is None:
                raise FieldError(f"'{key}' is not a name", (key,), key=True)
            found[str(key)] = nested(parse, one, key)
        except FieldError as error:
            errors.append(error)
    raise_all(errors)
    return found


_PATH = {"type": "string", "minLength": 1}
_SOURCE = {
    "type": "object",
    "minProperties": 1,
    "maxProperties": 1,
    "additionalProperties": False,
    "properties": {
        "from_environment": {"type": "string", "description": "a variable of the operator"},
        "from_file": {"type": "string", "description": "a file of the operator"},
    },
}

HOST_FIELDS = (
    Field(
        "address",
        FieldType(_address, {"type": "string", "minLength": 1}),
        "host name, IPv4 or IPv6 address, or a name of `~/.ssh/config`",
    ),
    Field("user", _matching("a user name", _USER, "robot"), "user there (default: as ssh has it)"),
    Field(
        "engine",
        choice(*(engine.value for engine in HostEngine)),
        "what supervises the processes there; `auto`: systemd where the host has it, else ssh",
    ),
    Field("ssh", SSH_OPTIONS, "options of OpenSSH by name, as in `{Port: 22}`"),
    Field(
        "python",
        FieldType(remote_path, _PATH),
        "Python with the launcher there, relative to the home (default: `python3`)",
    ),
    Field("venv", FieldType(remote_path, _PATH), "virtual environment there, instead of `python`"),
    Field(
        "ros",
        FieldType(remote_path, _PATH),
        "ROS 2 installation there, whose `setup.sh` is sourced, as in `/opt/ros/jazzy`",
    ),
    Field(
        "setup",
        FieldType(_setup, {"anyOf": [_PATH, {"type": "array", "items": _PATH}]}),
        "files there that a POSIX shell sources, in order",
    ),
    Field(
        "environment",
        FieldType(
            _variables, {"type": "object", "additionalProperties": {"anyOf": [_SCALAR, _SOURCE]}}
        ),
        "variables of the processes there",
    ),
    Field(
        "on_link_loss",
        FieldType(
            _on_link_loss,
            {
                "anyOf": [
                    {"const": "keep"},
                    {
                        "type": "string",
                        "pattern": f"^(?:stop-after *= *)?(?:{for_editors(DURATION_PATTERN)})$",
                        "examples": ["stop-after=10 s"],
                    },
                    {"type": "number", "minimum": 0},
                ]
            },
        ),
        "`keep`, or `stop-after=10 s`: what the host does while it cannot be reached",
    ),
    Field(
        "workspace",
        FieldType(remote_path, _PATH),
        "folder that `hosts sync` fills, relative to the home",
    ),
    Field(
        "node_selector",
        FieldType(_labels, {"type": "object", "additionalProperties": _SCALAR}),
        "labels of the Kubernetes node, for `export kubernetes`",
    ),
)
