"""Sources of Python packages that setuptools cannot pack."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.errors import LauncherError
from launcher.workspace.building.sources import Package
from launcher.workspace.building.wheel import python_package


def test_an_old_setuptools_is_not_a_mistake_in_setup_py(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    script = "raise SystemExit(\"error: invalid command 'bdist_wheel'\")"
    monkeypatch.setattr(python_package, "_BUILD", script)
    (tmp_path / "p").mkdir()

    with pytest.raises(
        LauncherError, match=r"setuptools .* cannot make a wheel of p: it is"
    ) as raised:
        python_package.contents(Package("p", str(tmp_path / "p"), "ament_python"))

    assert raised.value.where is None
    assert "pip install" in (raised.value.hint or "")
