"""Definitions: the text of an interface with the interfaces that it uses, indented."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from launcher.graph.errors import VerbError
from launcher.graph.interfaces import all_interfaces, interface_packages, near_miss

_PRIMITIVES = {"bool", "byte", "char", "float32", "float64", "string", "wstring"} | {
    f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)
}
# type, its bound (`<=10`), its array (`[<=3]`), name
_FIELD = re.compile(r"^(?P<type>[\w/]+)(<=\d+)?(\[[^\]]*\])?\s+\w+")


def resolve(name: str) -> str:
    """The full name of an installed interface; VerbError with a near miss."""
    known = all_interfaces()
    if name in known:
        return name
    short = [full for full in known if name == f"{full.split('/')[0]}/{full.split('/')[2]}"]
    if short:
        return short[0]
    near = near_miss(name)
    raise VerbError(f"Unknown interface '{name}'", hint=f"did you mean '{near}'?" if near else None)


def definition_path(full: str) -> Path:
    """The file that defines an interface."""
    package, kind, name = full.split("/")
    return interface_packages()[package] / "share" / package / kind / f"{name}.{kind}"


def show(full: str, *, comments: bool, nested_comments: bool, depth: int = 0) -> Iterator[str]:
    """The lines of a definition; what a field is made of follows it, one tab deeper."""
    for line in definition_path(full).read_text(encoding="utf-8").splitlines():
        code = _code(line)
        if comments:
            yield "\t" * depth + line.rstrip() if line.strip() else ""
        elif code:
            yield "\t" * depth + code
        if nested := _nested_type(code, full.split("/")[0]):
            yield from show(
                nested, comments=nested_comments, nested_comments=nested_comments, depth=depth + 1
            )


def _code(line: str) -> str:
    """The line without its comment; a # inside of a string constant is none."""
    if "'" in line or '"' in line:
        return line.strip() if not line.lstrip().startswith("#") else ""
    return line.partition("#")[0].strip()


def _nested_type(code: str, package: str) -> str | None:
    match = _FIELD.match(code)
    if match is None or match["type"] in _PRIMITIVES:
        return None
    *owner, name = match["type"].split("/")
    return f"{owner[0] if owner else package}/msg/{name}"
