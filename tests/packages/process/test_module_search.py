"""To look for a module changes nothing in this process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

LOOKS = {
    "a hint": "from launcher.packages import extras; extras.install_command('bag')",
    "a name": "from launcher.packages import extras; extras.is_installed('pip')",
    "a program": "from launcher.packages import imports; imports.imports_of('uses_pip.py')",
}


@pytest.mark.parametrize("look", LOOKS.values(), ids=LOOKS)
def test_setuptools_can_be_imported_after_pip_was_looked_for(tmp_path: Path, look: str):
    (tmp_path / "uses_pip.py").write_text("import pip\n")
    subprocess.run([sys.executable, "-c", f"{look}; import setuptools"], cwd=tmp_path, check=True)
