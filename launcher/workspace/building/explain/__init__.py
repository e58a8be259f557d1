"""Why a package was not built: one message with a place, from the output of its tools."""

from __future__ import annotations

import os
import re

from launcher.base.errors import LauncherError
from launcher.workspace.building.build_place import FULL_DISK_HINT
from launcher.workspace.building.explain import (
    cmake_errors,
    compiler_errors,
    python_errors,
    rosidl_errors,
)
from launcher.workspace.building.explain.build_output import BuildOutput
from launcher.workspace.building.sources.source_text import SourceError, shown

__all__ = ["BuildOutput", "explain"]


def explain(output: BuildOutput) -> LauncherError | None:
    """The first cause of a failure; None if nothing in the output is known. It only reads files."""
    for reader in (
        _full_disk,
        _out_of_memory,
        rosidl_errors.explain,
        _same_output,
        cmake_errors.explain,
        compiler_errors.explain,
        _not_writable,
        python_errors.explain,
        _missing_file,
        _failed_command,
    ):
        try:
            error = reader(output)
        except (OSError, SourceError):  # a file was removed in the meantime
            continue
        if error is not None:
            return error
    return None


def _full_disk(output: BuildOutput) -> LauncherError | None:
    """The disk is full, or was: at the end there may be space again. Some tools name a file."""
    if not output.has("No space left on device", "Disk quota exceeded", "[Errno 28]"):
        return None
    sign = "(?:No space left on device|Disk quota exceeded)"
    file = r"(?<![^\s:'\"])(?=[^\s:'\"]*/)([^\s:'\"]+)"  # from the start of a word: linear
    found = re.search(f"{file}['\"]?: '?{sign}|{sign}: ['\"]?{file}", output.text)
    path = os.path.join(output.build, (found[1] or found[2]) if found else "")
    return LauncherError(f"No space left on device: {shown(path.rstrip('/'))}", hint=FULL_DISK_HINT)


def _out_of_memory(output: BuildOutput) -> LauncherError | None:
    """A compiler that the kernel has killed, or that could not get more memory."""
    signs = (
        r"Killed signal terminated program",
        r"internal compiler error: Killed",
        r"virtual memory exhausted",
        r"\bout of memory\b",
        r"^(Memory|OutOfMemory)Error\b",
        r"^error: OutOfMemory",
        r"^Killed$",
        r"std::bad_alloc",
    )
    if not any(re.search(sign, output.text, re.MULTILINE) for sign in signs):
        return None
    return LauncherError(
        "the compiler was killed: there was too little memory",
        hint="build one package at a time, with one compiler: "
        "MAKEFLAGS=-j1 launcher build -- --executor sequential",
    )


def _same_output(output: BuildOutput) -> LauncherError | None:
    found = re.search(
        r"ninja: error: build\.ninja:\d+: (?:(\S+) is defined as an output multiple times"
        r"|multiple rules generate (\S+))",
        output.text,
    )
    if found is None:
        return None
    return output.error(
        f"two targets make the same file, {found[1] or found[2]}",
        os.path.join(output.folder, "CMakeLists.txt"),
        hint="is something listed twice?",
    )


def _not_writable(output: BuildOutput) -> LauncherError | None:
    pattern = (
        r"(?:Permission denied|Read-only file system|Operation not permitted):? '?(/[^'\n:]+)"
        r"|(/[^'\n:]+)'?: (?:Permission denied|Read-only file system)"
    )
    found = re.search(pattern, output.text)
    if found is None:
        return None
    path = found[1] or found[2]
    return LauncherError(f"{path} cannot be written", hint="check its owner and its permissions")


def _missing_file(output: BuildOutput) -> LauncherError | None:
    found = re.search(
        r"ninja: error: '([^']+)', needed by '[^']+', missing and no known", output.text
    )
    if found is None:
        return None
    hint = "if it was renamed or removed, remove it from CMakeLists.txt as well"
    return LauncherError(f"the file {found[1]} does not exist, and no rule makes it", hint=hint)


def _failed_command(output: BuildOutput) -> LauncherError | None:
    """A command of the package's CMakeLists.txt that says nothing about its failure."""
    found = re.search(r"^FAILED: .*\n(.*)$", output.text, re.MULTILINE)
    if found is None:
        return None
    command = re.sub(r"^(:|cd \S+) && ", "", found[1]).removesuffix(" && :")
    return LauncherError(f"a command failed: {command[:300]}")
