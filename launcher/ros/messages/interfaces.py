"""Installed message, service and action types: their names, definitions and Python classes."""

from __future__ import annotations

import importlib
import os
import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from launcher.ros.errors import VerbError
from launcher.ros.verb import warn
from launcher.text import suggest

KINDS = ("msg", "srv", "action")
_INDEX = Path("share/ament_index/resource_index/rosidl_interfaces")


def prefixes() -> list[Path]:
    """Where packages are installed; the first one wins."""
    words = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(word) for word in dict.fromkeys([*filter(None, words), sys.prefix])]


def interface_packages() -> dict[str, Path]:
    """Package with interfaces -> its prefix, sorted."""
    found: dict[str, Path] = {}
    for prefix in prefixes():
        if (prefix / _INDEX).is_dir():
            for entry in (prefix / _INDEX).iterdir():
                found.setdefault(entry.name, prefix)
    return dict(sorted(found.items()))


def interfaces_of(package: str, kinds: Iterable[str] = KINDS) -> list[str]:
    """Full names of a package's interfaces, sorted; empty if there is no such package."""
    prefix = interface_packages().get(package)
    if prefix is None:
        return []
    lines = (prefix / _INDEX / package).read_text(encoding="utf-8").splitlines()
    names = {line.rsplit(".", 1)[0] for line in lines if line.endswith(".idl")}
    return sorted(f"{package}/{name}" for name in names if name.split("/")[0] in kinds)


def all_interfaces(kinds: Iterable[str] = KINDS) -> list[str]:
    kinds = tuple(kinds)
    return [name for package in interface_packages() for name in interfaces_of(package, kinds)]


def load(type_name: str, kind: str, message: str) -> Any:
    """The class of `pkg/msg/Name` (or `pkg/Name`); VerbError with this message and a near miss."""
    package, _, rest = type_name.partition("/")
    name = rest.removeprefix(f"{kind}/")
    if package.isidentifier() and name.isidentifier():
        try:
            return getattr(importlib.import_module(f"{package}.{kind}"), name)
        except (ModuleNotFoundError, AttributeError):
            pass
    raise VerbError(message, hint=_hint(type_name, package, name, kind))


def load_message(type_name: str) -> Any:
    """The class of a message type; VerbError with the text of ros2cli."""
    return load(type_name, "msg", "The passed message type is invalid")


def _hint(type_name: str, package: str, name: str, kind: str) -> str | None:
    near = near_miss(type_name, [kind])
    if near is None:
        return f"no such type is installed: {type_name}"
    last = near.rsplit("/", 1)[1]
    same_package = near.startswith(f"{package}/") and last != name
    return f"did you mean {last}? ({near})" if same_package else f"did you mean {near}?"


def near_miss(type_name: str, kinds: Iterable[str] = KINDS) -> str | None:
    """The installed type with the most similar name; None if there is none."""
    package, name = type_name.partition("/")[0], type_name.rpartition("/")[2]
    known = all_interfaces(kinds)
    alike = [full for full in known if suggest(name, [full.rsplit("/", 1)[1]])]
    own = {full.rsplit("/", 1)[1]: full for full in alike if full.startswith(f"{package}/")}
    if last := suggest(name, own):
        return own[last]
    if package == name:  # there is no package in it
        same = [full for full in alike if full.endswith(f"/{name}")]
        return same[0] if len(same) == 1 else None
    return suggest(type_name, alike)


def full_type(name: str, kind: str = "msg") -> str:
    """`std_msgs/msg/String` for `std_msgs/String`; a name without a package is left as it is."""
    if "/" not in name:
        return name
    return f"{name.partition('/')[0]}/{kind}/{name.rpartition('/')[2]}"


def warn_if_unknown(full: str) -> None:
    """Warn if no such type is installed; others may use it all the same."""
    if full not in all_interfaces():
        near = near_miss(full)
        warn(f"hint: {f'did you mean {near}?' if near else f'no type {full} is installed here'}")


_PRIMITIVES = {"bool", "byte", "char", "float32", "float64", "string", "wstring"} | {
    f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)
}
# type, its bound (`<=10`), its array (`[<=3]`), name
_FIELD = re.compile(r"^(?P<type>[\w/]+)(<=\d+)?(\[[^\]]*\])?\s+\w+")


def resolve(name: str) -> str:
    """The full name of an installed interface; VerbError with a suggestion."""
    known = all_interfaces()
    if name in known:
        return name
    short = [full for full in known if name == f"{full.split('/')[0]}/{full.split('/')[2]}"]
    if short:
        return short[0]
    near = near_miss(name)
    raise VerbError(f"Unknown interface '{name}'", hint=f"did you mean '{near}'?" if near else None)


def definition_path(full: str) -> Path:
    package, kind, name = full.split("/")
    return interface_packages()[package] / "share" / package / kind / f"{name}.{kind}"


def show(full: str, *, comments: bool, nested_comments: bool, depth: int = 0) -> Iterator[str]:
    """The lines of a definition; the definition of a nested type follows its field, indented."""
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
    """The line without its comment; it keeps a # in a string constant."""
    if "'" in line or '"' in line:
        return line.strip() if not line.lstrip().startswith("#") else ""
    return line.partition("#")[0].strip()


def _nested_type(code: str, package: str) -> str | None:
    match = _FIELD.match(code)
    if match is None or match["type"] in _PRIMITIVES:
        return None
    *owner, name = match["type"].split("/")
    return f"{owner[0] if owner else package}/msg/{name}"
