"""Which packages Python compiles at every start, as the interpreter itself decides it."""

from __future__ import annotations

import importlib.util
import os
import py_compile
import sys
from pathlib import Path

import pytest

import launcher
from launcher.packages import byte_code
from launcher.packages.byte_code import STANDARD, VARIABLE, uncached

LAUNCHER = os.path.dirname(launcher.__file__)
INVALIDATION = py_compile.PycInvalidationMode


@pytest.fixture
def init(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An rclpy that is not compiled, beside a launcher that is; not all of `sys.path` is text."""
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path / "cache"))
    monkeypatch.setattr(byte_code, "_STANDARD_FOLDER", str(tmp_path / "python3"))
    py_compile.compile(byte_code.__file__)
    path = tmp_path / "my env/site-packages/rclpy/__init__.py"
    path.parent.mkdir(parents=True)
    path.write_text("NAME = 1\n")
    monkeypatch.setattr(sys, "path", [b"", tmp_path / "none", str(path.parents[1])])
    return path


def test_it_is_kept_where_it_can_be_written_or_is_there(init: Path):
    assert uncached({}) is None
    py_compile.compile(str(init))
    assert uncached({VARIABLE: "1"}) is None


def test_the_variable_keeps_it_from_being_written(init: Path):
    found = uncached({VARIABLE: "1"})
    assert found is not None and (found.names, found.is_by_variable) == (("rclpy",), True)
    site = str(init.parents[1])
    assert found.folders == (site,), "what it imports is compiled with it"
    assert found.command == f"{sys.executable} -m compileall -qq '{site}'"
    assert str(found) == f"Python compiles rclpy again at every start, since {VARIABLE} is set"
    assert uncached({VARIABLE: ""}) is None


@pytest.mark.parametrize("mode", INVALIDATION)
def test_byte_code_of_another_source_is_not_used(init: Path, mode: py_compile.PycInvalidationMode):
    py_compile.compile(str(init), invalidation_mode=mode)
    os.utime(init, (1, 1))
    is_by_time = mode is INVALIDATION.TIMESTAMP
    assert (uncached({VARIABLE: "1"}) is not None) is is_by_time


@pytest.mark.parametrize("size", [0, 15])
def test_a_torn_file_is_no_byte_code(init: Path, size: int):
    path = py_compile.compile(str(init))
    assert path is not None
    os.truncate(path, size)
    assert uncached({VARIABLE: "1"}) is not None


def test_modules_of_the_standard_library_are_looked_at_if_they_were_imported(
    init: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    folder = tmp_path / "python3"
    folder.mkdir()
    for name in ("shared", "unused"):
        (folder / f"{name}.py").touch()
    spec = importlib.util.spec_from_file_location("shared", f"{folder}/shared.py")
    assert spec is not None and uncached({}) is None
    monkeypatch.setitem(sys.modules, "shared", importlib.util.module_from_spec(spec))
    found = uncached({})
    assert found is not None and (found.names, found.folders) == ((STANDARD,), (str(folder),))
    py_compile.compile(f"{folder}/shared.py")
    assert uncached({}) is None


def test_a_folder_that_may_not_be_written_is_left_to_its_owner(
    init: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path / "none"))
    monkeypatch.setattr(byte_code.os, "access", lambda path, mode: False)
    found = uncached({})
    assert found is not None and not found.is_by_variable
    assert found.names == ("launcher", "rclpy")
    assert found.folders == tuple(sorted([LAUNCHER, str(init.parents[1])]))
    assert found.command.startswith(f"sudo {sys.executable} -m compileall -qq ")
    assert "launcher, rclpy again at every start, since it may not write" in str(found)
