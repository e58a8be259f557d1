"""The output folder: written as a whole, and what is not ours stays."""

from __future__ import annotations

import os
import resource
from pathlib import Path

import pytest

from launcher.base.errors import LauncherError, UsageError
from launcher.export.folder import LIST, Folder


def write(path: Path, files: dict[str, str]) -> None:
    folder = Folder(str(path))
    folder.check(files)
    folder.write(files)


def content(path: Path) -> dict[str, str]:
    found = (one for one in path.rglob("*") if one.is_file() and one.name != LIST)
    return {str(one.relative_to(path)): one.read_text() for one in found}


def test_a_second_export_replaces_the_first_and_removes_what_is_stale(tmp_path: Path):
    out = tmp_path / "new" / "out"
    write(out, {"a": "1", "sub/b": "2", "old/c": "3"})
    write(out, {"a": "4", "sub/b": "2"})
    assert content(out) == {"a": "4", "sub/b": "2"}
    assert not (out / "old").exists()


@pytest.mark.parametrize("before", [{}, {"a": "1", "old/c": "3"}])
def test_an_export_that_finds_no_room_leaves_all_as_it_was(tmp_path: Path, before: dict[str, str]):
    out = tmp_path / "out"
    if before:
        write(out, before)
    as_it_was = sorted(tmp_path.rglob("*"))
    files = {"a": "4", "sub/b": "5", "z": "6" * 10_000}
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (5_000, hard))
    try:
        with pytest.raises(LauncherError, match="File too large"):
            write(out, files)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert sorted(tmp_path.rglob("*")) == as_it_was
    assert content(out) == before
    write(out, files)
    assert content(out) == files


def test_a_file_of_the_last_export_gives_way_to_a_folder(tmp_path: Path):
    write(tmp_path, {"a": "1"})
    write(tmp_path, {"a/b": "2"})
    assert content(tmp_path) == {"a/b": "2"}


def test_what_a_killed_export_has_left_is_in_nobodys_way(tmp_path: Path):
    left = tmp_path / ".launcher-export.new" / "a"
    left.parent.mkdir()
    left.write_text("half")
    write(tmp_path, {"b": "1"})
    assert content(tmp_path) == {"b": "1"}


def test_a_folder_of_others_is_refused(tmp_path: Path):
    (tmp_path / "thesis.tex").touch()
    with pytest.raises(UsageError, match="not of an export"):
        write(tmp_path, {"a": "1"})
    assert content(tmp_path) == {"thesis.tex": ""}


def test_a_file_beside_the_exported_ones_stays(tmp_path: Path):
    write(tmp_path, {"a": "1"})
    (tmp_path / "own.env").write_text("X=1")
    write(tmp_path, {"b": "2"})
    assert content(tmp_path) == {"b": "2", "own.env": "X=1"}


def test_a_file_of_others_is_not_overwritten(tmp_path: Path):
    write(tmp_path, {"a": "1"})
    (tmp_path / "b").write_text("own")
    with pytest.raises(UsageError, match="is not of the last export"):
        write(tmp_path, {"a": "1", "b": "2"})
    assert content(tmp_path) == {"a": "1", "b": "own"}


@pytest.mark.parametrize("files", [{"a": "2"}, {}])
def test_a_changed_file_is_neither_overwritten_nor_removed(tmp_path: Path, files: dict[str, str]):
    write(tmp_path, {"a": "1"})
    (tmp_path / "a").write_text("mine")
    with pytest.raises(UsageError, match="was changed after the last export"):
        write(tmp_path, files)
    assert content(tmp_path) == {"a": "mine"}


def test_a_file_that_somebody_removed_is_written_again(tmp_path: Path):
    write(tmp_path, {"a": "1"})
    (tmp_path / "a").unlink()
    write(tmp_path, {"a": "1"})
    assert content(tmp_path) == {"a": "1"}


def test_a_file_in_place_of_the_folder_is_refused(tmp_path: Path):
    (tmp_path / "out").touch()
    with pytest.raises(UsageError, match="is not a folder"):
        write(tmp_path / "out", {"a": "1"})


def test_a_list_that_leads_elsewhere_removes_nothing(tmp_path: Path):
    (tmp_path / "victim").write_text("x")
    out = tmp_path / "out"
    out.mkdir()
    (out / LIST).write_text('{"files": {"../victim": "x", "/etc/hostname": "y"}}')
    write(out, {"a": "1"})
    assert (tmp_path / "victim").exists()


def test_what_cannot_be_written_is_told_with_its_path(tmp_path: Path):
    (tmp_path / "file").touch()
    with pytest.raises(LauncherError, match=r"cannot write '.*/file") as caught:
        write(tmp_path / "file" / "out", {"a": "1"})
    assert caught.value.exit_code == 1
    assert os.listdir(tmp_path) == ["file"]
