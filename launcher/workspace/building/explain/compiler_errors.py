"""Errors of compilers and linkers: gcc, and clang as in zig."""

from __future__ import annotations

import re

from launcher.base.errors import LauncherError
from launcher.base.program import program
from launcher.workspace.building.checks import origins
from launcher.workspace.building.explain.build_output import BuildOutput
from launcher.workspace.building.sources.source_text import PackageText

_ERROR = re.compile(
    r"^(?P<file>[^\s:][^:\n]*):(?P<line>\d+):(?P<column>\d+): (?:fatal )?error: (?P<text>.*)$",
    re.MULTILINE,
)
_LINES = 40  # places before an error that may say why the compiler is there
_PLACE = re.compile(
    r"^(?:In file included from )?(?P<file>[^\s:][^:\n]*):(?P<line>\d+)(?::(?P<column>\d+))?",
    re.MULTILINE,
)
_UNDEFINED = re.compile(
    r"undefined reference to [^\w\s](?P<gnu>.+)[^\w\s)]$|undefined symbol: (?P<lld>.+)$",
    re.MULTILINE,
)


def explain(output: BuildOutput) -> LauncherError | None:
    """The first error of a compiler, else of a linker."""
    found = _ERROR.search(output.text)
    if found is not None:
        return _compiled(output, found)
    return _linked(output)


def _compiled(output: BuildOutput, found: re.Match[str]) -> LauncherError:
    text = found["text"].strip()
    hint = None
    header = re.match(r"'?([^':]+)'?(?::| file) (?:No such file or directory|not found)", text)
    if header is not None:
        text, hint = _missing_header(header[1])
    place = _user_place(output, found)
    if place is None:
        where = f"{found['file']}:{found['line']}"
        return LauncherError(text, where=where, hint=hint)
    path, line, column = place
    return output.error(text, path, line, column, hint=hint)


def _user_place(output: BuildOutput, found: re.Match[str]) -> tuple[str, int, int | None] | None:
    """The place of an error, or what it is an error for: in the package's sources."""
    path = output.own(found["file"])
    if path is not None:
        return path, int(found["line"]), int(found["column"])
    # gcc names what needs a template in the lines before, clang in notes after it.
    following = _ERROR.search(output.text, found.end())
    end = following.start() if following else len(output.text)
    before = [*_PLACE.finditer(output.text, 0, found.start())][-_LINES:]
    after = [*_PLACE.finditer(output.text, found.end(), end)]
    needing = [
        one for one in (*reversed(before), *after) if _says(one, "required from", " requested")
    ]
    including = [one for one in reversed(before) if _says(one, "included from")]
    for place in (*needing, *including):
        path = output.own(place["file"])
        if path is not None:
            column = int(place["column"]) if place["column"] else None
            return path, int(place["line"]), column
    return None


def _says(place: re.Match[str], *signs: str) -> bool:
    end = place.string.find("\n", place.end())
    line = place.string[place.start() : end if end >= 0 else None]
    return any(sign in line for sign in signs)


def _missing_header(header: str) -> tuple[str, str | None]:
    name = header.split("/")[0].removesuffix(".h").removesuffix(".hpp")
    if header == "Python.h":
        return (
            "the header files of Python are missing",
            "install them (apt install python3-dev), or use a Python that has them",
        )
    if re.fullmatch(r"\w+/(msg|srv|action)/(detail/)?\w+\.hpp", header):
        return (
            f"{name} has no interfaces for C++: '{header}' does not exist",
            f"`{program()} build --cpp` generates those of the workspace",
        )
    if origins.is_of_ros(name, ()):
        return origins.missing(name, ())
    return f"the header file '{header}' does not exist", (
        "check the name, and target_include_directories() in CMakeLists.txt"
    )


def _linked(output: BuildOutput) -> LauncherError | None:
    found = _UNDEFINED.search(output.text)
    if found is not None:
        symbol = (found["gnu"] or found["lld"]).strip()
        message = f"nothing defines {symbol}, which is used here"
        hint = "add the file or library that has it: add_executable() or target_link_libraries()"
        path = _object_source(output)
        if path is None:
            return LauncherError(f"undefined reference to {symbol}", hint=hint)
        name = symbol.partition("(")[0].rpartition("::")[2]
        return output.error(message, path, _line_with(path, name), at=name, hint=hint)
    library = re.search(
        r"(?:cannot find -l|unable to find (?:dynamic system )?library '?-?l?)([\w.+-]+)",
        output.text,
    )
    if library is None:
        return None
    hint = "install it, or remove it from target_link_libraries() in CMakeLists.txt"
    return LauncherError(f"the library '{library[1]}' is not found", hint=hint)


def _object_source(output: BuildOutput) -> str | None:
    """The source file whose object needs the symbol."""
    for found in re.finditer(r"CMakeFiles/[^/\s]+\.dir/(\S+?)\.o\b", output.text):
        path = output.own(found[1])
        if path is not None:
            return path
    return None


def _line_with(path: str, name: str) -> int | None:
    """The last line that has the name: its uses are after its declaration."""
    lines = PackageText(path, errors="replace").lines if name else []
    return max((number for number, line in enumerate(lines, 1) if name in line), default=None)
