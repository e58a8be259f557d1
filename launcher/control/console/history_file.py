"""Where the console keeps the lines that were typed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from launcher.posix.state_folder import state_folder


def history_path(env: Mapping[str, str]) -> Path:
    """A file in the folder of what is remembered of the user."""
    return Path(state_folder(env), "history")
