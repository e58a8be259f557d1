"""Attempts to load an included launch file before it is visited."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.language.sources import AnyLaunchDescriptionSource, PythonLaunchDescriptionSource

INTERRUPTED = """
class Property:
    def __set_name__(self, owner, name):
        raise KeyboardInterrupt

class Settings:
    speed = Property()

def generate_launch_description():
    pass
"""


@pytest.mark.parametrize("kind", [AnyLaunchDescriptionSource, PythonLaunchDescriptionSource])
def test_a_ctrl_c_ends_also_an_attempt(kind: type, tmp_path: Path):
    """Before 3.12, Python makes a RuntimeError of it while a class is made."""
    file = tmp_path / "included.launch.py"
    file.write_text(INTERRUPTED)
    with pytest.raises(KeyboardInterrupt):
        kind(str(file)).try_get_launch_description_without_context()
