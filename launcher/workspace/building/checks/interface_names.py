"""Interfaces of a package that cannot be generated together: of one name, or recursive."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator, Mapping

from launcher.workspace.building.checks.interface_files import Reference
from launcher.workspace.building.checks.interface_index import interface_name
from launcher.workspace.building.sources import path_back
from launcher.workspace.building.sources.source_text import PackageText, SourceError

# The messages of a package: where each is defined, and its fields of the package's own types.
Fields = dict[str, tuple[PackageText, list[Reference]]]


def snake_case(name: str) -> str:
    """The name of the files that rosidl generates for an interface: `http_get` for `HTTPGet`."""
    name = re.sub(r"(.)([A-Z][a-z]+)", r"\1_\2", name)
    return re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", name).lower()


def same_names(source: PackageText, listed: Iterable[tuple[str, int]]) -> Iterator[SourceError]:
    """Files that are listed twice, or whose generated files have the same names."""
    seen: dict[str, tuple[str, int]] = {}
    for text, line in listed:
        folder, _, name = (interface_name(text) or "").rpartition("/")
        if not folder:
            continue
        generated = f"{folder}/{snake_case(name)}.h"
        if generated not in seen:
            seen[generated] = (text, line)
            continue
        first, first_line = seen[generated]
        if text == first:
            message = f"'{text}' is listed twice, first in line {first_line}"
            hint = "remove one of them"
            if line == first_line:
                yield source.error(message, *_second(source, text, line), hint=hint)
                continue
        else:
            message = f"'{first}' and '{text}' cannot both be generated: both make {generated}"
            hint = "rename one of them"
        yield source.error(message, line, at=text, hint=hint)


def _second(source: PackageText, text: str, line: int) -> tuple[int, int | None]:
    """Line and column of the second time that a line has a word."""
    found = re.finditer(rf"(?<![\w/]){re.escape(text)}(?!\w)", source.lines[line - 1])
    second = next(itertools.islice(found, 1, None), None)
    return line, second.start() + 1 if second else None


def recursions(fields: Mapping[str, tuple[PackageText, list[Reference]]]) -> Iterator[SourceError]:
    """Messages that contain themselves."""
    uses = {name: {one.name for one in own} & fields.keys() for name, (_, own) in fields.items()}
    done: set[str] = set()
    for name in sorted(uses):
        path = None if name in done else path_back(name, uses)
        if path is None:
            continue
        done.update(path)
        source, own = fields[name]
        field = next(one for one in own if one.name == path[1])
        way = f": {' -> '.join(path)}" if len(path) > 2 else ""
        yield source.error(
            f"'{name}' contains itself{way}",
            field.line,
            at=field.written,
            hint="refer to others by a number or a name: not even an array may hold the same type",
        )
