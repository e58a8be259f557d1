"""Installed message, service and action types: their names, definitions and Python classes."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from launcher.base import strict_json
from launcher.base.program import program
from launcher.base.ros_errors import VerbError
from launcher.base.text import suggest
from launcher.packages import unbuilt
from launcher.packages.workspace import current
from launcher.ros.messages.classes import check_fields, class_of, missing_package, parts_of
from launcher.ros.verb import warn

KINDS = ("msg", "srv", "action")
# Kind -> the other kinds of which such types are made: a service has a message for its events, an
# action has messages and services.
_MADE_OF = {"msg": ("srv", "action"), "srv": ("action",), "action": ()}
# What only the classes of this kind have.
_MARKS = {"msg": "get_fields_and_field_types", "srv": "Request", "action": "Goal"}
_NOUNS = {"msg": "a message", "srv": "a service", "action": "an action"}
_SHOWN = 6  # types in a hint
_INDEX = Path("share/ament_index/resource_index/rosidl_interfaces")


def interface_packages() -> dict[str, Path]:
    """Package with interfaces -> its prefix, of several the first one; sorted."""
    words = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    found: dict[str, Path] = {}
    for prefix in map(Path, dict.fromkeys([*filter(None, words), sys.prefix])):
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
    """The class of `pkg/msg/Name` (or `pkg/Name`); VerbError with this message and a near miss,
    or with the package that its fields need.
    """
    package, _, rest = type_name.partition("/")
    name, folder = rest.removeprefix(f"{kind}/"), kind
    for part in _MADE_OF[kind]:
        if name.startswith(f"{part}/"):
            folder, name = part, name.removeprefix(f"{part}/")
    if package.isidentifier() and name.isidentifier():
        try:
            found = class_of(package, folder, name)
        except (ModuleNotFoundError, AttributeError):
            pass
        else:
            if hasattr(found, _MARKS[kind]):
                check_fields(found)
                return found
    raise VerbError(message, hint=_hint(type_name, package, name, folder, kind))


def load_message(type_name: str) -> Any:
    """The class of a message type; VerbError with the text of ros2cli."""
    return load(type_name, "msg", "The passed message type is invalid")


def _hint(type_name: str, package: str, name: str, kind: str, wanted: str) -> str | None:
    not_built = unbuilt.hint(package, os.environ)
    if not_built is not None:
        return not_built
    if kind != wanted and (parts := parts_of(package, kind, name)):
        whole = name.partition("_")[0]
        return f"{package}/{kind}/{whole} is made of: {', '.join(parts)}"
    if type_name in interfaces_of(package):
        return f"{type_name} is {_NOUNS[type_name.split('/')[1]]}, not {_NOUNS[wanted]}"
    near = near_miss(type_name, [kind])
    if near is None:
        outside = _outside(package) if name else None
        return f"no such type is installed: {type_name}" + (f"; {outside}" if outside else "")
    last = near.rsplit("/", 1)[1]
    same_package = near.startswith(f"{package}/") and last != name
    return f"did you mean {last}? ({near})" if same_package else f"did you mean {near}?"


def absent(package: str) -> str | None:
    """What to do about the types of a package that are not found; None if the package is there."""
    return unbuilt.hint(package, os.environ) or _outside(package)


def none_installed() -> str | None:
    """What to do where no package has interfaces."""
    if interface_packages():
        return None
    from launcher.packages.absent_ros import none_here

    return none_here()


def _outside(package: str) -> str | None:
    """The hint for a package that a workspace may have, where none is visible."""
    if hint := none_installed():
        return hint
    if package in interface_packages() or current() is not None:
        return None
    return "types of a workspace are found only in its folder, or with --workspace DIR"


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
    if "/" not in name or any(f"/{part}/" in name for part in _MADE_OF[kind]):
        return name
    return f"{name.partition('/')[0]}/{kind}/{name.rpartition('/')[2]}"


def warn_if_unknown(full: str) -> None:
    """Warn if no such type is installed; others may use it all the same."""
    package, _, last = full.rpartition("/")
    if f"{package}/{last.partition('_')[0]}" not in all_interfaces():  # `X_Event` belongs to X
        not_built = unbuilt.hint(full.partition("/")[0], os.environ)
        if not_built is not None:
            warn(f"hint: {not_built}")
            return
        near = near_miss(full)
        outside = _outside(full.partition("/")[0])
        none = f"no type {full} is installed here" + (f"; {outside}" if outside else "")
        warn(f"hint: {f'did you mean {near}?' if near else none}")


def of_type(
    known: Mapping[str, Sequence[str]], type_name: str, kind: str
) -> dict[str, Sequence[str]]:
    """Those with this type; without any, a warning if no such type is installed."""
    full = full_type(type_name, kind)
    found = {name: types for name, types in known.items() if full in types}
    if not found:
        warn_if_unknown(full)
    return found


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
    hint = unbuilt.hint(name.partition("/")[0], os.environ) or none_installed()
    if hint is None and (near := near_miss(name)):
        hint = f"did you mean '{near}'?"
    raise VerbError(f"Unknown interface '{name}'", hint=hint or _containing(name, known))


def _containing(name: str, known: Sequence[str]) -> str:
    """The types whose name has the last part of this one in it."""
    part = name.rpartition("/")[2].lower()
    found = [full for full in known if part in full.rpartition("/")[2].lower()]
    if len(part) < 3 or not found:
        return f"{program()} interface list lists the installed types"
    more = f" and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
    return f"types with such a name: {', '.join(found[:_SHOWN])}{more}"


def definition_path(full: str) -> Path:
    """The file of an installed type; VerbError if its source is gone."""
    package, kind, name = full.split("/")
    folder = interface_packages()[package] / "share" / package / kind
    own = folder / f"{name}.{kind}"
    if own.is_symlink() and not own.exists():
        raise VerbError(
            f"the source of {full} is gone: {os.path.realpath(own)}",
            hint=f"to build without it: {program()} build",
        )
    return own if own.is_file() else own.with_suffix(".idl")  # it was written in IDL


def note_of_change(full: str) -> str | None:
    """That an installed definition, a link to its source, was edited after the build.

    `launcher.workspace.building.records` describes the record of the build. None without one.
    """
    package, kind, name = full.split("/")
    prefix = interface_packages().get(package)
    if prefix is None:
        return None
    path = prefix / "share" / package / kind / f"{name}.{kind}"
    if not path.is_symlink():
        return None
    import hashlib

    try:
        record = strict_json.loads((prefix / f"../../build/{package}/launcher.json").read_bytes())
        inside = os.path.relpath(os.path.realpath(path), record["place"]["source"])
        is_same = record["files"][inside][2] == hashlib.sha256(path.read_bytes()).hexdigest()[:32]
    except (OSError, ValueError, LookupError, TypeError):
        return None
    text = f"note: the definition of {full} has changed since the build: {program()} build"
    return None if is_same else text


def show(full: str, *, comments: bool, nested_comments: bool, depth: int = 0) -> Iterator[str]:
    """The lines of a definition; the definition of a nested type follows its field, indented.

    A definition in IDL is shown as it is.
    """
    path = definition_path(full)
    lines = path.read_text(encoding="utf-8").splitlines()
    if path.suffix == ".idl":
        yield from ("\t" * depth + line for line in lines)
        return
    for line in lines:
        code = code_of(line)
        if comments:
            yield "\t" * depth + line.rstrip() if line.strip() else ""
        elif code:
            yield "\t" * depth + code
        if nested := nested_type(code, full.split("/")[0]):
            _check_nested(full, nested)
            yield from show(
                nested, comments=nested_comments, nested_comments=nested_comments, depth=depth + 1
            )


def _check_nested(full: str, nested: str) -> None:
    """VerbError if the type of a field is not installed."""
    package = nested.split("/")[0]
    if package not in interface_packages():
        raise missing_package(full, package)
    if nested not in interfaces_of(package, ["msg"]):
        raise VerbError(f"{full} needs {nested}, which is not installed")


def code_of(line: str) -> str:
    """The line without its comment; it keeps a # in a string constant."""
    if "'" in line or '"' in line:
        return line.strip() if not line.lstrip().startswith("#") else ""
    return line.partition("#")[0].strip()


def nested_type(code: str, package: str) -> str | None:
    match = _FIELD.match(code)
    if match is None or match["type"] in _PRIMITIVES:
        return None
    *owner, name = match["type"].split("/")
    return f"{owner[0] if owner else package}/msg/{name}"
