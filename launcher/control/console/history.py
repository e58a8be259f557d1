"""History of entered lines: a file in the user's state folder, or memory."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Mapping
from pathlib import Path

from prompt_toolkit.history import History, InMemoryHistory

MAX_LINES = 1000


def history_path(env: Mapping[str, str]) -> Path:
    """`$XDG_STATE_HOME/ros-launcher/history`, by default below ~/.local/state."""
    root = env.get("XDG_STATE_HOME") or os.path.join(os.path.expanduser("~"), ".local", "state")
    return Path(root) / "ros-launcher" / "history"


def open_history(path: Path) -> History:
    """The history in this file, shortened if need be; in memory if it cannot be written."""
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with open(os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600), "r+") as file:
            lines = list(filter(None, file.read().split("\n")))
            if len(lines) > 2 * MAX_LINES:
                file.seek(0)
                file.truncate()
                file.writelines(f"{line}\n" for line in lines[-MAX_LINES:])
    except (OSError, UnicodeDecodeError):
        return InMemoryHistory()
    return _LinesInFile(path, lines[-MAX_LINES:])


class _LinesInFile(History):
    """One entry per line; several consoles append to the same file."""

    def __init__(self, path: Path, lines: list[str]) -> None:
        super().__init__()
        self._path = path
        self._lines = lines

    def load_history_strings(self) -> Iterable[str]:
        """Newest first."""
        return reversed(self._lines)

    def store_string(self, string: str) -> None:
        """Append a line; a full disk is ignored."""
        with contextlib.suppress(OSError), self._path.open("a", encoding="utf-8") as file:
            file.write(string + "\n")
