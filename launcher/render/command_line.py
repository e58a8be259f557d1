"""Command lines that a person can copy and paste, and the parameter files that they name."""

from __future__ import annotations

import contextlib
import hashlib
import os
import shlex
import stat
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from launcher.model.spec import ProcessSpec

_PRIVATE = 0o700


def command_line(
    spec: ProcessSpec, environment: Mapping[str, str], files: Mapping[str, str]
) -> str:
    """One line for a shell whose environment is `environment`.

    `files` has, for parameter files that the launcher wrote for the plan, the path where they
    can be found now.
    """
    words = [files.get(word, word) for word in spec.argv]
    if spec.shell:
        # As `subprocess` does it: the words as one text, for a shell to take apart.
        words = ["sh", "-c", " ".join(words)]
    around = _environment_words(spec.env, environment)
    if spec.cwd is not None:
        around = ["-C", spec.cwd, *around]
    if around:
        words = ["env", *around, *words]
    return " ".join(map(shell_word, words))


def _environment_words(env: Mapping[str, str], before: Mapping[str, str]) -> list[str]:
    words: list[str] = []
    for name in sorted(before):
        if name not in env:
            words += ["-u", name]
    return [*words, *(f"{k}={v}" for k, v in sorted(env.items()) if before.get(k) != v)]


class ParameterFiles:
    """Keeps the generated parameter files of a plan where a pasted command finds them.

    A file is named after its content, so that planning again makes no new ones; the folder is
    the user's own. Where it cannot be written, the path of a file is None.
    """

    def __init__(self) -> None:
        self._folder: Path | None = None

    def keep(self, label: str, content: Mapping[str, Any]) -> tuple[str | None, str]:
        """(path, text) of a file with this content for the process with this label."""
        import yaml

        text = yaml.safe_dump(_plain(content), default_flow_style=False, sort_keys=False)
        digest = hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()[:12]
        with contextlib.suppress(OSError):
            path = self._own_folder() / f"{_file_name(label)}-{digest}.yaml"
            path.write_text(text, encoding="utf-8", errors="surrogateescape")
            return str(path), text
        return None, text

    def _own_folder(self) -> Path:
        if self._folder is None:
            folder = Path(tempfile.gettempdir()) / f"launcher-plan-{os.getuid()}"
            with contextlib.suppress(FileExistsError):
                folder.mkdir(_PRIVATE)
            # Anybody may make a folder of this name before us: it counts only if it is ours.
            found = folder.lstat()
            ours = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
            if not ours or stat.S_IMODE(found.st_mode) & 0o022:
                folder = Path(tempfile.mkdtemp(prefix="launcher-plan-"))
            self._folder = folder
        return self._folder


def _file_name(label: str) -> str:
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in label)[:60] or "node"


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return value


_NAMED = {"\n": r"\n", "\t": r"\t", "\r": r"\r", "\x1b": r"\e", "\\": r"\\", "'": r"\'"}


def shell_word(word: str) -> str:
    """The word in quotes where it needs them; `$'...'` with escapes if it cannot be printed.

    What stands for a byte that is no UTF-8 (as in file names of Python) becomes that byte again.
    """
    if word.isprintable():
        return shlex.quote(word)
    return "$'" + "".join(map(_escaped, word)) + "'"


def _escaped(char: str) -> str:
    if char in _NAMED:
        return _NAMED[char]
    if char.isprintable():
        return char
    # Bytes in octal: of these a shell reads three digits at most, whatever follows.
    try:
        data = char.encode(errors="surrogateescape")
    except UnicodeEncodeError:
        return char  # no program can be given it
    return "".join(f"\\{byte:03o}" for byte in data)
