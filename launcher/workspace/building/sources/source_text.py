"""Source files of packages as text, and errors with a place in them."""

from __future__ import annotations

import os
import re
from functools import cached_property, partialmethod

from launcher.base import text_file
from launcher.base.errors import ExitCode, LauncherError

_BOM = "\ufeff"
_MAX_SHOWN = 160  # characters of a source line; longer ones are generated


class SourceError(LauncherError):
    """What is to be built is wrong: found before anything is built."""

    exit_code = ExitCode.USAGE
    package: str | None = None  # the package that cannot be built; None if its name is not known


class SourceWarning(SourceError):
    """The package is built, but not as its author may expect."""

    def render(self) -> str:
        return super().render().replace("error: ", "warning: ", 1)


class PackageText:
    """A text file of a package. Raises SourceError if it cannot be read."""

    def __init__(self, path: str, *, errors: str = "strict") -> None:
        self.path = path
        text = _read(path, errors)
        self.has_bom = text.startswith(_BOM)
        self.text = text.removeprefix(_BOM)

    @cached_property
    def lines(self) -> list[str]:
        return re.split(r"\r\n|\r|\n", self.text)

    def line_of(self, offset: int) -> tuple[int, int]:
        """Line and column, from 1, of a position in the text."""
        before = re.split(r"\r\n|\r|\n", self.text[:offset])
        return len(before), len(before[-1]) + 1

    def error(
        self,
        message: str,
        line: int | None = None,
        column: int | None = None,
        *,
        at: str | None = None,
        hint: str | None = None,
        kind: type[SourceError] = SourceError,
    ) -> SourceError:
        """An error in this file; the caret points to `column`, or to the text `at` in the line."""
        where, text = shown(self.path), None
        if line is not None:
            where = f"{where}:{line}"
            text = self.lines[line - 1] if line <= len(self.lines) else ""
            if at is not None and at in text:
                word = re.search(rf"(?<!\w){re.escape(at)}(?!\w)", text)
                column = (word.start() if word else text.index(at)) + 1
            text, column = _shortened(text, column)
        return kind(message, where=where, source_line=text or None, column=column, hint=hint)

    warning = partialmethod(error, kind=SourceWarning)

    def find(self, word: str) -> tuple[int | None, int | None]:
        """Line and column of the first occurrence of a word."""
        found = re.search(rf"(?<!\w){re.escape(word)}(?!\w)", self.text)
        return self.line_of(found.start()) if found else (None, None)


def _shortened(text: str, column: int | None) -> tuple[str, int | None]:
    """The line without its indentation and its far end, and the column in it."""
    text = text.expandtabs(1).rstrip()
    code = text.lstrip()
    if column is not None:
        column -= len(text) - len(code)
        if not 0 < column <= min(len(code), _MAX_SHOWN) + 1:
            column = None
    return code if len(code) <= _MAX_SHOWN else f"{code[:_MAX_SHOWN]}...", column


def shown(path: str) -> str:
    """The path as users know it: relative to the working directory if it is below it."""
    try:
        relative = os.path.relpath(path)
    except (OSError, ValueError):
        return path
    return path if relative == ".." or relative.startswith("../") else relative


def _read(path: str, errors: str) -> str:
    try:
        data = text_file.read_bytes(path)
    except OSError as error:
        raise SourceError(f"cannot be read: {error.strerror}", where=shown(path)) from None
    try:
        return data.decode("utf-8", errors)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise SourceError(
            "the file is not encoded in UTF-8",
            where=f"{shown(path)}:{line}",
            hint="save it as UTF-8 in your editor",
        ) from None
