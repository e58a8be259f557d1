"""Which files a release has."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from launcher.base.errors import LauncherError
from launcher.hosts.sync.release_tree import Release, Tree


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "package"
    (folder / "sub").mkdir(parents=True)
    (folder / "a.yaml").write_text("a")
    (folder / "sub/b.yaml").write_text("b")
    return folder


def added(package: Path, *roots: Path) -> Tree:
    tree = Tree()
    tree.add_folder("p", str(package), [str(root) for root in roots or (package,)])
    tree.check()
    return tree


def test_files_keep_their_places_and_whether_they_are_executable(package: Path):
    (package / "run").write_text("#!/bin/sh\n")
    (package / "run").chmod(0o6755)

    tree = added(package)

    assert {*tree.entries} == {"p/a.yaml", "p/sub/b.yaml", "p/run"}
    assert [one.path for one in tree.entries.values() if one.is_executable] == ["p/run"]


@pytest.mark.parametrize(
    "name", [".git", ".env", ".env.local", "__pycache__", ".netrc", ".ssh", "x.pyc", "a~", ".a.swp"]
)
def test_secrets_and_what_tools_made_stay_here(package: Path, name: str):
    (package / name).mkdir()
    (package / name / "inside").write_text("secret")
    (package / "sub" / name).write_text("secret")

    tree = added(package)

    assert {*tree.entries} == {"p/a.yaml", "p/sub/b.yaml"}


def test_links_within_the_folder_stay_links(package: Path):
    (package / "sub/link").symlink_to("../a.yaml")

    assert added(package).entries["p/sub/link"].target == "../a.yaml"


def test_links_into_a_root_are_followed(package: Path, tmp_path: Path):
    source = tmp_path / "src"
    source.mkdir()
    (source / "c.yaml").write_text("c")
    (package / "c.yaml").symlink_to(source / "c.yaml")
    (package / "folder").symlink_to(source)

    tree = added(package, source)

    assert b"".join(tree.entries["p/c.yaml"].blocks()) == b"c"
    assert "p/folder/c.yaml" in tree.entries


def test_links_that_lead_elsewhere_are_errors(package: Path, tmp_path: Path):
    (tmp_path / "key").write_text("secret")
    (package / "config").symlink_to(tmp_path / "key")
    (package / "up").symlink_to("../key")

    with pytest.raises(LauncherError) as caught:
        added(package)

    assert caught.value.render().count("leads out of its package") == 2
    assert str(tmp_path / "key") in caught.value.message


def test_a_dead_link_is_an_error(package: Path):
    (package / "gone").symlink_to("/nowhere")

    with pytest.raises(LauncherError, match="gone leads to /nowhere, which does not exist"):
        added(package)


def test_a_loop_of_links_ends(package: Path):
    (package / "sub/again").symlink_to(package)

    assert "p/sub/b.yaml" in added(package).entries


def test_what_is_no_file_is_told(package: Path):
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(package / "socket"))
        os.mkfifo(package / "fifo")
        tree = added(package)

    assert {*tree.left_out.values()} == {"no regular file"}
    assert len(tree.left_out) == 2


def test_the_id_depends_on_contents_places_and_modes_only(package: Path):
    first = Release([*added(package).entries.values()]).id
    os.utime(package / "a.yaml", (0, 0))
    assert Release([*added(package).entries.values()]).id == first
    (package / "a.yaml").chmod(0o755)
    second = Release([*added(package).entries.values()]).id
    (package / "a.yaml").write_text("other")
    third = Release([*added(package).entries.values()]).id
    assert len({first, second, third}) == 3


def test_names_that_are_no_text_have_an_id(package: Path):
    with open(os.path.join(os.fsencode(package), b"\xff\n"), "wb"):
        pass

    assert Release([*added(package).entries.values()]).id
