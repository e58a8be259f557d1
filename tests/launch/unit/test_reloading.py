"""Which modules a new evaluation of the launch file imports again."""

from __future__ import annotations

import json
import sysconfig
from pathlib import Path

from launcher.base import text
from launcher.launch.reloading import is_own


def test_what_colcon_has_installed_is_the_users_own(tmp_path: Path):
    assert is_own(f"{tmp_path}/install/fleet/lib/python3.10/site-packages/fleet/parts.py")
    assert is_own(f"{tmp_path}/src/fleet/parts.py")


def test_what_pip_ros_or_python_have_installed_is_not():
    installed = f"{sysconfig.get_path('purelib')}/some/part.py"
    of_ros = "/opt/ros/jazzy/lib/python3.12/site-packages/launch/action.py"
    for path in (installed, of_ros, json.__file__, text.__file__, None, "<string>", "part.py"):
        assert not is_own(path)
