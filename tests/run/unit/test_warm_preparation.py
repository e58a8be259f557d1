"""What the preparing process does not do to the modules that it has imported."""

from __future__ import annotations

import importlib.util
import inspect
import sys
from pathlib import Path

import pytest

from launcher.run.warm import preparation, preparing_service


def test_a_module_that_is_loaded_at_the_first_look_is_left_to_the_programs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """It may start threads, which a forked process lacks."""
    loaded = tmp_path / "loaded"
    (tmp_path / "late.py").write_text(f"open({str(loaded)!r}, 'w').close()")
    spec = importlib.util.spec_from_file_location("late", tmp_path / "late.py")
    assert spec is not None and spec.loader is not None
    spec.loader = importlib.util.LazyLoader(spec.loader)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setitem(sys.modules, "late", module)
    monkeypatch.setattr(inspect, "modulesbyfile", {})  # of other tests
    preparation._find_files()
    assert preparation.__file__ in list(preparing_service._modules())
    assert preparation.is_lazy(module)
    assert not loaded.exists()
