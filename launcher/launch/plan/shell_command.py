"""Command lines to paste into a shell, with their parameter files."""

from __future__ import annotations

import contextlib
import os
import shlex
import stat
from collections.abc import Mapping
from pathlib import Path

from launcher.base.model.parameter_text import file_text
from launcher.base.model.spec import ProcessSpec, replaces
from launcher.launch.plan.plan_json import changed_variables

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_PRIVATE = 0o700
_NAMED = {"\n": r"\n", "\t": r"\t", "\r": r"\r", "\x1b": r"\e", "\\": r"\\", "'": r"\'"}


def command_line(
    spec: ProcessSpec, environment: Mapping[str, str], files: Mapping[str, str]
) -> str:
    """A line for a shell whose environment is `environment`.

    `files` maps the parameter files in `spec` to where they can be found now.
    """
    words = [files.get(word, word) for word in spec.argv]
    if spec.shell:
        # As in `subprocess`: one string that the shell splits.
        words = ["sh", "-c", " ".join(words)]
    around = _environment_words(spec.env, environment)
    if spec.cwd is not None:
        around = ["-C", spec.cwd, *around]
    if around:
        words = ["env", *around, *words]
    return " ".join(map(shell_word, words))


def _environment_words(env: Mapping[str, str], before: Mapping[str, str]) -> list[str]:
    if replaces(env, before):
        return ["-i", *(f"{name}={value}" for name, value in sorted(env.items()))]
    words: list[str] = []
    for name in sorted(before):
        if name not in env:
            words += ["-u", name]
    return [*words, *(f"{k}={v}" for k, v in sorted(changed_variables(env, before).items()))]


class ParameterFileWriter:
    """Writes the generated parameter files of a plan for commands that are pasted later.

    The name of a file contains a hash of its content, so the next plan reuses it.
    """

    def __init__(self) -> None:
        self._folder: Path | None = None

    def keep(self, label: str, content: Mapping[str, Any]) -> tuple[str | None, str]:
        """(path, text) of a file with this content; the path is None if it cannot be written."""
        import hashlib  # takes 3 ms

        text = file_text(content)

        digest = hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()[:12]
        with contextlib.suppress(OSError):
            path = self._own_folder() / f"{_file_name(label)}-{digest}.yaml"
            path.write_text(text, encoding="utf-8", errors="surrogateescape")
            return str(path), text
        return None, text

    def _own_folder(self) -> Path:
        if self._folder is None:
            import tempfile

            folder = Path(tempfile.gettempdir()) / f"launcher-plan-{os.getuid()}"
            with contextlib.suppress(FileExistsError):
                folder.mkdir(_PRIVATE)
            # The folder may belong to another user.
            found = folder.lstat()
            is_own = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
            if not is_own or stat.S_IMODE(found.st_mode) & 0o022:
                folder = Path(tempfile.mkdtemp(prefix="launcher-plan-"))
            self._folder = folder
        return self._folder


def _file_name(label: str) -> str:
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in label)[:60] or "node"


def shell_word(word: str) -> str:
    """The word in quotes if it needs them; in `$'...'` with escapes if it is not printable.

    Surrogate escapes, which stand for bytes that are not UTF-8, become these bytes.
    """
    if word.isprintable():
        return shlex.quote(word)
    return "$'" + "".join(map(_escaped, word)) + "'"


def _escaped(char: str) -> str:
    if char in _NAMED:
        return _NAMED[char]
    if char.isprintable():
        return char
    # In octal: a shell reads at most three digits, whatever follows.
    try:
        data = char.encode(errors="surrogateescape")
    except UnicodeEncodeError:
        return char  # cannot be passed to any program
    return "".join(f"\\{byte:03o}" for byte in data)
