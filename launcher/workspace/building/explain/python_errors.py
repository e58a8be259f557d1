"""Failures of setup.py, setuptools and of other Python programs of a package."""

from __future__ import annotations

import os
import re

from launcher.base.errors import LauncherError
from launcher.base.text import did_you_mean
from launcher.workspace.building.explain.build_output import BuildOutput

_FRAME = re.compile(r'^\s*File "(?P<file>[^"\n]+)", line (?P<line>\d+)', re.MULTILINE)
_LAST = re.compile(r"^ {0,3}([A-Za-z_][\w.]*)(?:: (.*))?$")


def explain(output: BuildOutput) -> LauncherError | None:
    """The first error of setuptools, else the last traceback."""
    found = _no_metadata(output) or _data_file(output) or _folder(output)
    return found or _traceback(output) or _setup_command(output)


def _no_metadata(output: BuildOutput) -> LauncherError | None:
    """colcon's own traceback is left if setup.py succeeds without it."""
    if "_get_setup_information" not in output.text or "CalledProcessError" not in output.text:
        return None
    hint = "it has to call setup() whenever it runs"
    return _in_setup(output, "setup.py does not give the metadata of the package", "setup(", hint)


def _data_file(output: BuildOutput) -> LauncherError | None:
    found = re.search(
        r"error: can't copy '([^']+)': doesn't exist or not a regular file", output.text
    )
    if found is None:
        return None
    name = os.path.relpath(found[1], output.build) if os.path.isabs(found[1]) else found[1]
    if name.startswith(".."):
        name = found[1]
    hint = None
    if os.path.isdir(os.path.join(output.folder, name)):
        hint = f"it is a folder: write glob('{name}/*')"
    return _in_setup(output, f"the file '{name}' in data_files does not exist", name, hint)


def _folder(output: BuildOutput) -> LauncherError | None:
    found = re.search(r"error: package directory '([^']+)' does not exist", output.text)
    if found is None:
        return None
    folders = [entry.name for entry in os.scandir(output.folder) if entry.is_dir()]
    name = found[1]
    hint = did_you_mean(name, [one for one in folders if not one.startswith(".")])
    return _in_setup(output, f"the Python package '{name}' does not exist", name, hint)


def _setup_command(output: BuildOutput) -> LauncherError | None:
    found = re.search(r"^error in .+ setup command: (.*)$", output.text, re.MULTILINE)
    found = found or re.search(r"^error: (.*)$", output.text, re.MULTILINE)
    return _in_setup(output, f"setuptools: {found[1]}", "setup(", None) if found else None


def _in_setup(output: BuildOutput, message: str, word: str, hint: str | None) -> LauncherError:
    """An error at the line of setup.py that has the word."""
    path = os.path.join(output.folder, "setup.py")
    try:
        with open(path, encoding="utf-8") as file:
            lines = file.read().splitlines()
    except (OSError, UnicodeDecodeError):
        return LauncherError(message, hint=hint)
    for text in (word, os.path.basename(word)):
        for number, line in enumerate(lines, start=1):
            if text in line:
                return output.error(message, path, number, at=text, hint=hint)
    return output.error(message, path, hint=hint)


def _traceback(output: BuildOutput) -> LauncherError | None:
    """The error of the last traceback, at the innermost line of the package's own files."""
    begin = output.text.rfind("Traceback (most recent call last):")
    text = output.text[begin:] if begin >= 0 else output.text
    frames = list(_FRAME.finditer(text))
    if not frames:
        return None
    message = _message(text[frames[-1].end() :].splitlines())
    if message is None:
        return None
    for frame in reversed(frames):
        path = output.own(frame["file"])
        if path is not None:
            return output.error(message, path, int(frame["line"]))
    return LauncherError(message) if begin >= 0 else None


def _message(lines: list[str]) -> str | None:
    """`ValueError: no input`, the line after the last frame and its source line."""
    for line in lines[1:]:
        found = _LAST.match(line)
        if found is not None:
            name = found[1].rpartition(".")[2]
            return f"{name}: {found[2]}" if found[2] else name
    return None
