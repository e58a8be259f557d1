"""The error for a Python package that is not installed, where the launcher came without pip."""

from __future__ import annotations

import sys

from launcher.base.errors import UsageError
from launcher.packages.absent_ros import has_ros, misfit, ros_hint
from launcher.packages.extras import install_command
from launcher.packages.package_origins import is_of_ros

# Module -> what brings it: a command, or an extra of this distribution.
_PACKAGES = {
    "yaml": "pip install pyyaml (Debian, Ubuntu: apt install python3-yaml)",
    "rich": "pip install rich (Debian, Ubuntu: apt install python3-rich)",
    "psutil": "pip install psutil (Debian, Ubuntu: apt install python3-psutil)",
    "lz4": "EXTRA bag",
    "mcap": "EXTRA bag",
    "mcap_ros2": "EXTRA bag",
    "zstandard": "EXTRA bag",
    "prompt_toolkit": "pip install prompt_toolkit "
    "(Debian, Ubuntu: apt install python3-prompt-toolkit)",
}
# What modules of an installed ROS 2 import.
_BESIDE_ROS = {
    "numpy": "pip install numpy (Debian, Ubuntu: apt install python3-numpy)",
    "lark": "pip install lark (Debian, Ubuntu: apt install python3-lark)",
}


def absent_module(error: ModuleNotFoundError) -> UsageError | None:
    """The error for users; None if it is no package that the launcher uses."""
    name = (error.name or "").partition(".")[0]
    hint = _PACKAGES.get(name) or _BESIDE_ROS.get(name)
    if is_of_ros(name) or (name in _BESIDE_ROS and misfit()):
        name = name if has_ros() else "rclpy"  # that users recognize
        hint = ros_hint()
    elif hint is None:
        return None
    elif hint.startswith("EXTRA "):
        hint = install_command(hint.removeprefix("EXTRA "))
    return UsageError(
        f"this needs the Python package '{name}', which {sys.executable} does not have", hint=hint
    )
