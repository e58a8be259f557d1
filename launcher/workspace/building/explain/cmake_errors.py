"""Errors of CMake: the place is the user's line, not that of the macro that noticed it."""

from __future__ import annotations

import re
from dataclasses import dataclass

from launcher.base.errors import LauncherError
from launcher.base.text import did_you_mean
from launcher.workspace.building.checks import origins
from launcher.workspace.building.explain.build_output import BuildOutput
from launcher.workspace.building.sources.source_text import PackageText

_HEAD = re.compile(
    r"^CMake Error(?: at (?P<file>.+?):(?P<line>\d+)(?: \((?P<command>\w+)\))?)?:(?P<text>.*)$"
)
_FRAME = re.compile(r"^  (?P<file>\S.*?):(?P<line>\d+) \((?P<command>\w+)\)$")
_COMMANDS = re.findall(
    r"\w+",
    "add_compile_definitions add_compile_options add_custom_command add_custom_target "
    "add_definitions add_dependencies add_executable add_library add_subdirectory "
    "ament_export_dependencies ament_export_include_directories ament_export_libraries "
    "ament_export_targets ament_package ament_python_install_module ament_python_install_package "
    "ament_target_dependencies configure_file else elseif endforeach endfunction endif endmacro "
    "execute_process file find_library find_package find_program foreach function "
    "get_filename_component if include include_directories install link_directories "
    "link_libraries list macro message option project rosidl_generate_interfaces "
    "rosidl_get_typesupport_target set set_property set_target_properties string "
    "target_compile_definitions target_compile_features target_compile_options "
    "target_include_directories target_link_libraries target_sources unset while",
)


@dataclass(frozen=True)
class CMakeFrame:
    """A line that CMake was in, and the command of this line."""

    file: str
    line: int
    command: str


def explain(output: BuildOutput) -> LauncherError | None:
    """The first error of CMake."""
    lines = output.text.splitlines()
    for number, line in enumerate(lines):
        head = _HEAD.match(line)
        if head is not None:
            return _explained(output, head, lines[number + 1 :])
    return None


def _explained(output: BuildOutput, head: re.Match[str], rest: list[str]) -> LauncherError:
    frames = []
    if head["file"]:
        frames.append(CMakeFrame(head["file"], int(head["line"]), head["command"] or ""))
    message, stack = _body(rest)
    frames += stack
    text = head["text"].strip() or _first_paragraph(message)
    if head["command"] == "message" and output.own(head["file"]) is not None:
        text = " ".join(" ".join(message).split())  # written by the package itself
    text, hint = _known(text, message)
    for frame in frames:
        path = output.own(frame.file)
        if path is not None:
            return output.error(text, path, frame.line, at=frame.command or None, hint=hint)
    return _without_place(output, text, hint)


def _without_place(output: BuildOutput, text: str, hint: str | None) -> LauncherError:
    """An error of a step that has no line; for a file to install it is the line that names it."""
    path = output.own("CMakeLists.txt")
    name = re.search(r"/([^/']+)/?' is to be installed", text)
    if path is None or name is None:
        return LauncherError(text, hint=hint)
    source = PackageText(path, errors="replace")
    line, column = source.find(name[1])
    return output.error(text, path, line, column, hint=hint)


def _body(lines: list[str]) -> tuple[list[str], list[CMakeFrame]]:
    """The indented message, and the call stack, up to the next message."""
    message: list[str] = []
    frames: list[CMakeFrame] = []
    in_stack = False
    for line in lines:
        if line.startswith("Call Stack"):
            in_stack = True
        elif line and not line.startswith(" "):
            break
        elif in_stack:
            found = _FRAME.match(line)
            if found is None:
                break
            frames.append(CMakeFrame(found["file"], int(found["line"]), found["command"]))
        else:
            message.append(line)
    return message, frames


def _first_paragraph(lines: list[str]) -> str:
    """The first paragraph as one line, with the next one if it is a list: `... file:`."""
    paragraphs: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            paragraphs[-1].append(line.strip())
        elif paragraphs[-1]:
            paragraphs.append([])
    texts = [" ".join(paragraph) for paragraph in paragraphs if paragraph]
    if not texts:
        return "CMake failed"
    if texts[0].endswith(":") and len(texts) > 1:
        return f"{texts[0]} {texts[1].removeprefix('- ')}"
    return texts[0]


def _known(text: str, message: list[str]) -> tuple[str, str | None]:
    """Message and hint for frequent errors; others are kept word for word."""
    whole = " ".join(line.strip() for line in message)
    unknown = re.search(r'Unknown CMake command "(\w+)"', text)
    if unknown is not None:
        return f"CMake has no command '{unknown[1]}'", _command_hint(unknown[1])
    package = re.search(r'configuration file provided by "([^"]+)"', whole)
    if package is not None:
        name = package[1]
        if origins.is_of_ros(name, ()):
            return origins.missing(name, ())
        return (
            f"CMake does not find the package '{name}'",
            f"install it with its CMake files, or say where they are: launcher build -- "
            f"--cmake-args -D{name}_DIR=FOLDER",
        )
    missing = re.search(r"can't find\s+'([^']+)'|INSTALL cannot find\s+\"([^\"]+)\"", whole)
    if missing is not None:
        return f"'{missing[1] or missing[2]}' is to be installed, and does not exist", None
    text = re.sub(r"\s+See documentation for policy \S+ for more details\.", "", text)
    return text.rstrip(".") if text.count(". ") == 0 else text, None


def _command_hint(name: str) -> str | None:
    lower = name.lower()
    if lower in _COMMANDS or lower.startswith(("ament_auto_", "rosidl_")):
        wanted = "rosidl_default_generators" if lower.startswith("rosidl_") else "ament_cmake"
        if lower.startswith("ament_auto_"):
            wanted = "ament_cmake_auto"
        return f"add find_package({wanted} REQUIRED) before it"
    return did_you_mean(lower, _COMMANDS)
