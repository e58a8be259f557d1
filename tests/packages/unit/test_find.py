"""Which workspace a folder is in, and which one a path names."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.base.errors import UsageError
from launcher.packages.workspace import MARKER, VARIABLE, current, find, workspace_at


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A workspace with a source folder."""
    return make_workspace(tmp_path / "ws")


def make_workspace(root: Path, install: str = "install") -> Path:
    (root / "src/pkg/pkg").mkdir(parents=True)
    (root / install).mkdir()
    (root / install / MARKER).write_text("isolated\n")
    return root


@pytest.mark.parametrize("below", ["", "src", "src/pkg/pkg", "install", "build/pkg"])
def test_a_workspace_is_found_from_every_folder_in_it(root: Path, below: str):
    (root / below).mkdir(parents=True, exist_ok=True)
    found = find(str(root / below))
    assert found is not None
    assert (found.root, found.install) == (str(root), str(root / "install"))


def test_a_link_to_a_workspace_is_the_workspace(root: Path, tmp_path: Path):
    (tmp_path / "link").symlink_to(root)
    for found in (find(str(tmp_path / "link/src")), workspace_at(str(tmp_path / "link"))):
        assert found is not None
        assert (found.root, found.install) == (str(root), str(root / "install"))


def test_the_nearest_workspace_counts(root: Path):
    inner = make_workspace(root / "src/inner")
    found = find(str(inner / "src"))
    assert found is not None and found.root == str(inner)


def test_an_install_folder_of_something_else_makes_no_workspace(tmp_path: Path):
    (tmp_path / "install/bin").mkdir(parents=True)
    assert find(str(tmp_path)) is None


def test_a_folder_that_is_gone_is_in_no_workspace(tmp_path: Path, monkeypatch):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    assert find() is None


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files away")
def test_an_install_folder_of_another_user_counts_only_in_folders_of_that_user(root: Path):
    mine = root / "mine"
    mine.mkdir()
    for uid, start, is_found in ((1234, mine, False), (1234, root / "src", True)):
        os.chown(mine, 77, -1)
        os.chown(root / "src", uid, -1)
        os.chown(root / "install", uid, -1)
        assert (find(str(start)) is not None) == is_found


def test_the_variable_chooses_another_workspace_or_none(root: Path, tmp_path: Path, monkeypatch):
    other = make_workspace(tmp_path / "öther ws")
    monkeypatch.chdir(root)
    monkeypatch.setenv(VARIABLE, str(other))
    chosen = current()
    assert chosen is not None and chosen.root == str(other)
    monkeypatch.setenv(VARIABLE, "")
    assert current() is None
    monkeypatch.delenv(VARIABLE)
    found = current()
    assert found is not None and found.root == str(root)


def test_a_path_may_name_the_install_folder(tmp_path: Path):
    root = make_workspace(tmp_path / "ws", "install_zig")
    found = workspace_at(str(root / "install_zig"))
    assert (found.root, found.install) == (str(root), str(root / "install_zig"))


def test_a_path_that_names_no_workspace_is_refused_with_a_suggestion(root: Path, tmp_path: Path):
    (tmp_path / "new/src").mkdir(parents=True)
    (tmp_path / "file").touch()
    for path, message, hint in (
        (root / "src", "is not a workspace: it has no install/", f"did you mean {root}?"),
        (tmp_path / "new", "is not a workspace: it has no install/", "build --workspace"),
        (tmp_path, "is not a workspace: it has no install/", "name the folder that has src/"),
        (tmp_path / "newx", "does not exist", "did you mean 'new'?"),
        (
            tmp_path / "none/ws",
            "does not exist",
            "it comes from --workspace, or from LAUNCHER_WORKSPACE",
        ),
        (
            tmp_path / "file",
            "is not a folder",
            "it comes from --workspace, or from LAUNCHER_WORKSPACE",
        ),
    ):
        with pytest.raises(UsageError, match=message) as caught:
            workspace_at(str(path))
        assert hint in str(caught.value.hint)
