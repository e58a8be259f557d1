"""Definitions in IDL as the text of message definitions, which readers of bags understand."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rosidl_parser.definition import (
    Action,
    BasicType,
    Message,
    Service,
)
from rosidl_parser.parser import parse_idl_string

from launcher.base.ros_errors import VerbError

_BASIC = {
    "boolean": "bool",
    "octet": "byte",
    "char": "char",
    "wchar": "uint16",  # as Fast CDR sends it; message definitions have no such type
    "float": "float32",
    "double": "float64",
    "short": "int16",
    "unsigned short": "uint16",
    "long": "int32",
    "unsigned long": "uint32",
    "long long": "int64",
    "unsigned long long": "uint64",
    **{f"{sign}int{bits}": f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)},
}
# What ROS's generator adds to a structure without fields, since IDL has none of these.
_FILLER = "structure_needs_at_least_one_member"


def sections(path: Path) -> list[str]:
    """One text for a message, two for a service, three for an action; VerbError."""
    try:
        content = parse_idl_string(path.read_text(encoding="utf-8"))
    except Exception as error:  # whatever the parser raises, AssertionError among others
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise VerbError(f"{path} cannot be read: {reason}") from None
    return [_text(message) for message in _messages(content)]


def _messages(content: Any) -> Iterator[Any]:
    yield from content.get_elements_of_type(Message)
    for service in content.get_elements_of_type(Service):
        yield from (service.request_message, service.response_message)
    for action in content.get_elements_of_type(Action):
        yield from (action.goal, action.result, action.feedback)


def _text(message: Any) -> str:
    lines = [f"# {line}".rstrip() for line in message.structure.get_comment_lines()]
    for constant in message.constants:
        lines += [f"# {line}".rstrip() for line in constant.get_comment_lines()]
        kind = _type(constant.type).partition("<=")[0]  # constants have no bound
        lines.append(f"{kind} {constant.name}={_literal(constant.value)}")
    for member in message.structure.members:
        if member.name != _FILLER:
            lines += [f"# {line}".rstrip() for line in member.get_comment_lines()]
            lines.append(f"{_type(member.type)} {member.name}{_default(member)}")
    return "".join(f"{line}\n" for line in lines)


def _type(kind: Any) -> str:
    """The type of a field, by the attributes of the parser's classes."""
    if hasattr(kind, "value_type"):
        return _type(kind.value_type) + _brackets(kind)
    if hasattr(kind, "namespaced_name"):
        package, *_, name = kind.namespaced_name()
        return f"{package}/{name}"
    if isinstance(kind, BasicType):
        if kind.typename not in _BASIC:
            raise VerbError(f"message definitions have no type '{kind.typename}'")
        return _BASIC[kind.typename]
    name = "wstring" if type(kind).__name__.endswith("WString") else "string"
    return f"{name}<={kind.maximum_size}" if kind.has_maximum_size() else name


def _brackets(kind: Any) -> str:
    if hasattr(kind, "size"):
        return f"[{kind.size}]"
    return f"[<={kind.maximum_size}]" if kind.has_maximum_size() else "[]"


def _default(member: Any) -> str:
    if not member.has_annotation("default"):
        return ""
    value = member.get_annotation_value("default")["value"]
    if hasattr(member.type, "value_type"):  # the text of a tuple
        try:
            items = ast.literal_eval(value)
        except (ValueError, SyntaxError):
            return ""
        return f" [{', '.join(map(_literal, items))}]"
    return f" {_literal(value)}"


def _literal(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
        return f'"{escaped}"'
    return repr(value)
