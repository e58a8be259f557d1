"""Mistakes in includes: a file that does not exist, a cycle, an argument that nobody declares."""

from __future__ import annotations

import os
import re
from types import CodeType, FunctionType, MethodType

from launcher.base.text import launch_stem, suggest
from launcher.language.configurations import ROS_NAMES
from launcher.language.diagnostics.error_details import details
from launcher.language.diagnostics.origin import FileLine
from launcher.language.diagnostics.truth_values import configurations_in

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import Any

    from launcher.language.context import LaunchContext

_MAX_OBJECTS = 20_000  # the search for uses of a name ends there
_MAX_LISTED = 8  # names in a hint
_MAX_LINES = 10  # of an include, searched for the file name
_SUFFIX = re.compile(r"[._]launch\.(py|xml|ya?ml)$")


# ---- a file that does not exist


def explain_missing(error: BaseException, path: str, origin: FileLine | None) -> None:
    """Attach message, hint and place to an error about an included file that does not exist."""
    place = None if origin is None else _line_of_file(origin, os.path.basename(path))
    for one in (error, error.__cause__):
        if one is not None:
            known = details(one)
            known.message = f"the included launch file {path} does not exist"
            known.place, known.hint = place, _near_file(path, origin)
            known.word = os.path.basename(path)


def _line_of_file(origin: FileLine, name: str) -> FileLine:
    """The line of the include that has the file name, else its first line."""
    import linecache

    lines = linecache.getlines(origin.path)[origin.line - 1 :]
    for number, line in enumerate(lines[:_MAX_LINES], start=origin.line):
        if name in line:
            return FileLine(origin.path, number)
    return origin


def _near_file(path: str, origin: FileLine | None) -> str | None:
    folder, name = os.path.split(path)
    if not os.path.isdir(folder):
        parent = os.path.dirname(folder)
        while not os.path.isdir(parent) and parent != os.path.dirname(parent):
            parent = os.path.dirname(parent)
        missing = os.path.relpath(folder, parent).split(os.sep)[0]
        near = suggest(missing, _folders(parent))
        hint = f"the folder {os.path.join(parent, missing)} does not exist"
        return f"{hint}; did you mean '{near}'?" if near else hint
    files = [one for one in os.listdir(folder) if os.path.isfile(os.path.join(folder, one))]
    # Without the suffix, which makes all names of launch files similar.
    stems = {_SUFFIX.sub("", one): one for one in sorted(files)}
    near = suggest(_SUFFIX.sub("", name), stems) or suggest(launch_stem(name), stems)
    if near is not None:
        return f"did you mean '{stems[near]}'?"
    for below in _folders(folder):
        if os.path.isfile(os.path.join(folder, below, name)):
            return f"did you mean '{os.path.join(below, name)}'?"
    if origin is not None and os.path.isfile(os.path.join(os.path.dirname(origin.path), name)):
        return f"relative paths are those below {folder}; write {_beside(name, origin)}"
    launch_files = sorted(filter(_SUFFIX.search, files))
    listed = ", ".join(launch_files[:_MAX_LISTED]) or "none"
    return f"launch files in {folder}: {listed}"


def _beside(name: str, includer: FileLine) -> str:
    """How a launch file names a file in its own folder."""
    if includer.is_python:
        return f"PathJoinSubstitution([ThisLaunchFileDir(), '{name}'])"
    return f"$(dirname)/{name}"


def _folders(folder: str) -> list[str]:
    try:
        names = sorted(os.listdir(folder))
    except OSError:
        return []
    return [one for one in names if os.path.isdir(os.path.join(folder, one))]


# ---- a cycle


def cycle(context: LaunchContext | None) -> tuple[str, FileLine] | None:
    """(sentence, place of an include) if the launch files include each other."""
    if context is None:
        return None
    includers = context._includers
    for start in includers:
        chain, file = [start], start
        while (origin := includers.get(file)) is not None:
            file = origin.file
            if file == start:
                return _cycle([*reversed(chain), start], includers)
            if file in chain:
                break
            chain.append(file)
    return None


def _cycle(files: list[str], includers: dict[str, FileLine | None]) -> tuple[str, FileLine] | None:
    # Written from the file that was launched, as far as it is in the cycle.
    first = next((one for one in includers if one in files), files[0])
    at = files.index(first) if first in files[:-1] else 0
    ring = [*files[:-1][at:], *files[:-1][:at]]
    names = [os.path.basename(one) for one in ring]
    names = ring if len(set(names)) < len(names) else names
    origin = includers[ring[1 % len(ring)]]
    if origin is None:
        return None
    subject = (
        "the launch file includes itself" if len(ring) == 1 else "launch files include each other"
    )
    return f"{subject} endlessly: {' -> '.join([*names, names[0]])}", origin


# ---- arguments that are no pairs


class NotPairsError(ValueError):
    """The `launch_arguments` of an include are not pairs, but most often a dictionary."""

    ros_type = "ValueError"

    def __init__(self, origin: FileLine | None) -> None:
        super().__init__("launch_arguments takes pairs of name and value")
        from launcher.language.diagnostics import source_code

        where = ("IncludeLaunchDescription", "launch_arguments")
        place = None if origin is None else source_code.keyword_place(origin, *where)
        known = details(self)
        known.hint = "write launch_arguments={...}.items()"
        known.place, known.word = place or origin, "launch_arguments"


# ---- an argument that the included file does not declare


def warn_of_unknown(
    context: LaunchContext, include: Any, description: Any, unknown: list[str]
) -> None:
    """Warn of arguments of an include that the other file neither declares nor reads.

    Where functions might read them, only of those that are similar to a declared one.
    """
    known = [argument.name for argument, _ in description._declarations(loads=False)]
    uses = _Uses(description)
    for name in unknown:
        if name in uses.names or name in ROS_NAMES or uses.is_cut_off:
            continue
        near = suggest(name, known)
        if uses.may_read_others and (near is None or _differ_in_digits(name, near)):
            continue
        path = os.path.basename(include._get_launch_file())
        listed = ", ".join(known[:_MAX_LISTED]) + (", ..." if len(known) > _MAX_LISTED else "")
        hint = f"did you mean '{near}'?" if near else f"it declares: {listed}"
        text = f"{path} does not declare the argument '{name}', which is ignored; hint: {hint}"
        context._host.warn_quirk(text, _line_with(include._origin, name))


def _differ_in_digits(one: str, other: str) -> bool:
    return re.sub(r"\d", "", one) == re.sub(r"\d", "", other)


def _line_with(origin: FileLine, name: str) -> FileLine:
    """The line of the include that has the name, else its first line."""
    import ast
    import linecache

    from launcher.language.diagnostics import source_code

    if not origin.is_python:
        written = re.compile(rf"name\s*[=:]\s*['\"]?{re.escape(name)}(?!\w)")
        lines = linecache.getlines(origin.path)
        for number, line in enumerate(lines[origin.line - 1 :], start=origin.line):
            if written.search(line):
                return FileLine(origin.path, number)
        return origin
    for node in source_code.nodes_at(origin):
        for one in ast.walk(node) if isinstance(node, ast.Call) else ():
            is_name = isinstance(one, ast.Constant) and one.value == name
            if is_name or (isinstance(one, ast.keyword) and one.arg == name):
                return FileLine(origin.path, one.lineno)  # type: ignore[attr-defined]
    return origin


class _Uses:
    """Launch configurations that a description may read, without running anything of it.

    `may_read_others`: it has functions, or includes that are not loaded yet.
    """

    def __init__(self, description: object) -> None:
        self.names: set[str] = set()
        self.may_read_others = False
        self._seen: dict[int, Any] = {}  # the objects are kept, or an id might be used again
        waiting: list[Any] = [description]
        while waiting and len(self._seen) < _MAX_OBJECTS:
            part = waiting.pop()
            if id(part) in self._seen or isinstance(part, (str, bytes, int, float, type(None))):
                continue
            self._seen[id(part)] = part
            waiting += self._parts_of(part)
        self.is_cut_off = bool(waiting)

    def _parts_of(self, part: Any) -> list[Any]:
        if isinstance(part, dict):
            return [*part.keys(), *part.values()]
        if isinstance(part, (list, tuple, set, frozenset)):
            return list(part)
        if isinstance(part, MethodType):
            part = part.__func__
        if isinstance(part, FunctionType):
            return self._function(part)
        if not type(part).__module__.startswith(("launch.", "launch_ros.", "launcher.")):
            self.may_read_others |= hasattr(type(part), "perform") or hasattr(type(part), "visit")
            return []
        if getattr(part, "_to_arguments", "") == "declares":
            self.names.add(part.name)
        below: list[Any] = [*vars(part).values()]
        if getattr(part, "_to_arguments", "") == "includes":
            loaded = part.launch_description_source._loaded
            self.may_read_others |= loaded is None
            below.append(loaded)
        self.names.update(configurations_in(part))
        return below

    def _function(self, function: FunctionType) -> list[Any]:
        if function.__module__.startswith("launcher."):
            return []
        self.may_read_others = True
        self.names.update(_texts_in(function.__code__))
        return [cell.cell_contents for cell in function.__closure__ or ()]


def _texts_in(code: CodeType) -> Iterator[str]:
    """Every string constant of a function, since it may be a name that it reads."""
    waiting: list[Any] = [code]
    while waiting:
        constant = waiting.pop()
        if isinstance(constant, str):
            yield constant
        elif isinstance(constant, (tuple, frozenset)):
            waiting += constant
        elif isinstance(constant, CodeType):
            waiting += constant.co_consts
