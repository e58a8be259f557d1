"""Where the console keeps the lines that were typed."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path


def history_path(env: Mapping[str, str]) -> Path:
    """`$XDG_STATE_HOME/ros-launcher/history`, by default below ~/.local/state."""
    root = env.get("XDG_STATE_HOME") or os.path.join(os.path.expanduser("~"), ".local", "state")
    return Path(root) / "ros-launcher" / "history"
