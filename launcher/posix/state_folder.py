"""The folder of what the launcher remembers of a user: typed lines, and notices that were shown."""

from __future__ import annotations

import os
from collections.abc import Mapping


def state_folder(env: Mapping[str, str]) -> str:
    """`$XDG_STATE_HOME/ros-launcher`, by default below ~/.local/state; it need not exist."""
    root = env.get("XDG_STATE_HOME") or os.path.expanduser("~/.local/state")
    return os.path.join(root, "ros-launcher")
