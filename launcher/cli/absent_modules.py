"""The error for a Python package that is not installed, where the launcher came without pip."""

from __future__ import annotations

import sys

from launcher.base.errors import LauncherError
from launcher.packages.extras import install_command, ros_hint
from launcher.packages.package_origins import has_wheel

# Module -> what brings it: a command, or an extra of this distribution. Beside an installation of
# ROS 2 the last ones are missing.
_PACKAGES = {
    "yaml": "pip install pyyaml (Debian, Ubuntu: apt install python3-yaml)",
    "rich": "pip install rich (Debian, Ubuntu: apt install python3-rich)",
    "mcap": "EXTRA bag",
    "mcap_ros2": "EXTRA bag",
    "zstandard": "EXTRA bag",
    "prompt_toolkit": "pip install prompt_toolkit "
    "(Debian, Ubuntu: apt install python3-prompt-toolkit)",
}


def absent_module(error: ModuleNotFoundError) -> LauncherError | None:
    """The error for users; None if it is no package that the launcher uses."""
    name = (error.name or "").partition(".")[0]
    hint = _PACKAGES.get(name)
    if has_wheel(name):  # beside `rclpy` generators and messages
        hint = ros_hint()
    elif hint is None:
        return None
    elif hint.startswith("EXTRA "):
        hint = install_command(hint.removeprefix("EXTRA "))
    return LauncherError(
        f"this needs the Python package '{name}', which {sys.executable} does not have", hint=hint
    )
