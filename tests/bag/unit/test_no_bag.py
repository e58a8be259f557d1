"""Files that are no bags: pointers of Git LFS, pipes and other formats."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.bag import check, metadata
from launcher.bag import verbs as bag_verb
from launcher.bag.bag_model import BagError
from launcher.bag.reader import Bag

POINTER = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"


@pytest.mark.parametrize("name", ["a.mcap", "a.db3", "a.mcap.zstd", "a.db3.zstd"])
def test_a_pointer_of_git_lfs_is_called_that(tmp_path: Path, name: str):
    path = tmp_path / name
    path.write_text(POINTER)
    for read in (Bag, check.check):
        with pytest.raises(BagError) as caught:
            read(str(path))
        assert caught.value.message == f"{path} is a pointer of Git LFS in place of the file"
        assert "git lfs pull" in (caught.value.hint or "")


def test_metadata_that_are_a_pointer_of_git_lfs(folder: Path):
    (folder / metadata.FILE).write_text(POINTER)
    with pytest.raises(BagError, match=r"metadata.yaml is a pointer of Git LFS"):
        Bag(str(folder))


def test_a_pipe_is_no_bag(tmp_path: Path):
    os.mkfifo(tmp_path / "a.mcap")
    with pytest.raises(BagError, match=r"a\.mcap is not a file"):
        Bag(str(tmp_path / "a.mcap"))


@pytest.mark.parametrize(
    ("name", "contents", "text"),
    [
        ("a.db3", b"", "is empty"),
        ("a.db3", b"no database", "file is not a database"),
        ("a.mcap", b"no bag at all", "it is not an MCAP file"),
        ("a.txt", b"no bag at all", "is not an MCAP file"),
    ],
)
def test_no_repair_of_what_is_no_bag(tmp_path: Path, capsys, name: str, contents: bytes, text: str):
    path = tmp_path / name
    path.write_bytes(contents)
    assert bag_verb.main(["check", str(path)]) == 1
    found = capsys.readouterr()
    assert text in found.out
    assert not found.err
    with pytest.raises(BagError) as caught:
        Bag(str(path))
    assert "recover" not in caught.value.render()
