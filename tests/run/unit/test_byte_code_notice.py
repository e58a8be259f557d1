"""The line about byte code that is lost: once for each installation."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from launcher.packages.byte_code import VARIABLE
from launcher.run.byte_code_notice import FILE, ByteCodeNotice


@pytest.fixture(autouse=True)
def _nothing_is_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path / "none"))


def said(state: str) -> list[tuple[str, ...]]:
    """What a run with this XDG_STATE_HOME logs."""
    lines: list[tuple[str, ...]] = []
    log = SimpleNamespace(log=lambda *words: lines.append(words))
    env = {VARIABLE: "1", "XDG_STATE_HOME": state}
    ByteCodeNotice(SimpleNamespace(env=env, log=log)).begin()  # type: ignore[arg-type]
    return lines


def test_it_is_said_once_for_each_installation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    state = str(tmp_path / "state")
    ((level, logger, text),) = said(state)
    assert (level, logger) == ("INFO", "launch")
    assert text.startswith("Python compiles launcher") and text.endswith("launcher doctor`")
    assert said(state) == []
    other = tmp_path / "o\n\udcff\u20ac/rclpy"
    other.mkdir(parents=True)
    (other / "__init__.py").touch()
    monkeypatch.syspath_prepend(str(other.parent))
    assert len(said(state)) == 1
    assert said(state) == []


@pytest.mark.parametrize("place", ["a file", "a folder", "no text", "full", "no home"])
def test_nothing_is_said_where_that_cannot_be_remembered(tmp_path: Path, place: str):
    state = tmp_path / "state"
    file = state / "ros-launcher" / FILE
    if place == "a file":
        state.touch()
    elif place == "a folder":
        file.mkdir(parents=True)
    elif place in ("no text", "full"):
        file.parent.mkdir(parents=True)
        file.write_bytes(b"\xff") if place == "no text" else file.symlink_to("/dev/full")
    before = sorted(os.listdir())
    assert said("~nobody/x" if place == "no home" else str(state)) == []
    assert sorted(os.listdir()) == before
