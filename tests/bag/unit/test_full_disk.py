"""A disk that is full: what was written before is a whole bag."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.bag import metadata
from launcher.bag.metadata import Metadata
from tests.support.bags import counting, write_bag

MOUNT = 'mount -t tmpfs -o size=200k none "$1" && shift && exec "$@"'


@pytest.mark.parametrize(
    "storage",
    [
        {"chunk_compression": "none"},
        {"chunk_compression": "zstd"},
        {"chunk_compression": "none", "max_bytes": 20_000},
        {"chunk_compression": "none", "max_bytes": 1},
    ],
)
def test_the_bag_is_whole(tmp_path: Path, storage: dict[str, object]):
    disk = str(tmp_path)
    program = [sys.executable, "-B", "-m", "tests.support.full_disk", disk, json.dumps(storage)]
    done = subprocess.run(
        ["unshare", "-Urm", "sh", "-c", MOUNT, "sh", disk, *program],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["whole"], report
    assert report["first ones"], report
    assert report["found"] == report["described"], report
    assert report["found"] >= report["written"] / 2, report
    assert report["files"] == sorted([*report["listed"], metadata.FILE]), report


def test_metadata_that_cannot_be_written_leave_nothing(tmp_path: Path, monkeypatch):
    folder = write_bag(tmp_path / "b", counting("/a", 3))
    before = sorted(folder.iterdir())
    told = metadata.read(str(folder))
    assert isinstance(told, Metadata)

    def full(*_: object) -> None:
        raise OSError("full")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="full"):
        metadata.write(str(folder), told)
    assert sorted(folder.iterdir()) == before
