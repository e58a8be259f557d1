"""The job server that the compilers of a build share."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from launcher.workspace.building import builder


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def test_the_variable_names_a_pipe_that_is_removed(temporary: Path):
    with builder.job_server({"A": "b"}) as environ:
        pipe = Path(environ["MAKEFLAGS"].partition("fifo:")[2])
        assert environ["A"] == "b"
        assert pipe.is_fifo()
        assert temporary in pipe.parents
    assert not list(temporary.iterdir())


def test_options_of_the_user_are_left(temporary: Path):
    with builder.job_server({"MAKEFLAGS": "-j1"}) as environ:
        assert environ == {"MAKEFLAGS": "-j1"}


def test_a_folder_that_the_variable_cannot_name(temporary: Path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(temporary / "a b"))
    with builder.job_server({}) as environ:
        assert environ == {}
