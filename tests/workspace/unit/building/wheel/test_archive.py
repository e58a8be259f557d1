"""The bytes of wheels: the same for the same entries, and a RECORD that pip accepts."""

from __future__ import annotations

import base64
import csv
import hashlib
import os
import stat
import subprocess
import sys
import zipfile

import pytest

from launcher.base.errors import LauncherError, UsageError
from launcher.workspace.building.wheel.archive import WheelEntry, timestamp, write

INFO = "p-1.0.dist-info"


@pytest.fixture
def entries(tmp_path):
    program = tmp_path / "größe.py"
    program.write_text("print(1)\n")
    return [
        WheelEntry("p/größe.py", str(program)),
        WheelEntry(f"{INFO}/METADATA", b"Name: p\n"),
        WheelEntry("p-1.0.data/data/bin/p", b"#!/bin/sh\n", is_executable=True),
        WheelEntry("p/a,b.py", b""),
    ]


def test_order_time_and_mode_of_the_files_do_not_count(tmp_path, entries):
    write(str(tmp_path / "a.whl"), entries, INFO, timestamp(None))
    os.utime(entries[0].source, (1, 1))
    os.chmod(entries[0].source, 0o600)
    write(str(tmp_path / "b.whl"), entries[::-1], INFO, timestamp(None))
    assert (tmp_path / "a.whl").read_bytes() == (tmp_path / "b.whl").read_bytes()


def test_record_has_the_digest_of_every_file(tmp_path, entries):
    write(str(tmp_path / "a.whl"), entries, INFO, timestamp(None))
    with zipfile.ZipFile(tmp_path / "a.whl") as wheel:
        rows = list(csv.reader(wheel.read(f"{INFO}/RECORD").decode().splitlines()))
        assert [row[0] for row in rows] == wheel.namelist()
        for name, digest, size in rows[:-1]:
            data = wheel.read(name)
            expected = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=")
            assert (digest, int(size)) == (f"sha256={expected.decode()}", len(data))
        assert rows[-1] == [f"{INFO}/RECORD", "", ""]


def test_modes_and_time(tmp_path, entries):
    write(str(tmp_path / "a.whl"), entries, INFO, timestamp("1700000000"))
    with zipfile.ZipFile(tmp_path / "a.whl") as wheel:
        modes = {
            info.filename: stat.filemode(info.external_attr >> 16) for info in wheel.infolist()
        }
        times = {info.date_time for info in wheel.infolist()}
    assert modes.pop("p-1.0.data/data/bin/p") == "-rwxr-xr-x"
    assert set(modes.values()) == {"-rw-r--r--"}
    assert times == {(2023, 11, 14, 22, 13, 20)}


@pytest.mark.parametrize(
    ("text", "seconds"),
    [(None, 315532800), ("", 315532800), ("0", 315532800), ("9" * 15, 4354819199)],
)
def test_times_that_a_zip_file_cannot_have(tmp_path, entries, text, seconds):
    assert timestamp(text) == seconds
    write(str(tmp_path / "a.whl"), entries, INFO, timestamp(text))


def test_a_wrong_time_is_an_error():
    with pytest.raises(UsageError, match="SOURCE_DATE_EPOCH is 'now'"):
        timestamp("now")


@pytest.mark.parametrize("is_file", [False, True])
def test_a_file_beyond_the_limit_of_32_bits(tmp_path, monkeypatch, is_file):
    monkeypatch.setattr(zipfile, "ZIP64_LIMIT", 1000)
    data = os.urandom(2000)
    (tmp_path / "big").write_bytes(data)
    write(
        str(tmp_path / "a.whl"),
        [WheelEntry("big", str(tmp_path / "big") if is_file else data)],
        INFO,
        timestamp(None),
    )
    with zipfile.ZipFile(tmp_path / "a.whl") as wheel:
        assert wheel.read("big") == data


def test_a_file_that_cannot_be_read_leaves_nothing(tmp_path, entries):
    with pytest.raises(LauncherError, match="gone cannot be read: No such file"):
        write(
            str(tmp_path / "a.whl"),
            [*entries, WheelEntry("p/b", str(tmp_path / "gone"))],
            INFO,
            timestamp(None),
        )
    assert [path.name for path in tmp_path.iterdir() if "whl" in path.name] == []


def test_a_folder_that_cannot_be_written_is_named(tmp_path, entries):
    with pytest.raises(LauncherError, match=r"a\.whl cannot be written: No such file"):
        write(str(tmp_path / "missing" / "a.whl"), entries, INFO, timestamp(None))


def test_a_full_disk_leaves_the_old_wheel(tmp_path, entries):
    """The limit of a file's size fails as a full disk does: write() reports it."""
    target = tmp_path / "a.whl"
    write(str(target), entries, INFO, timestamp(None))
    old = target.read_bytes()
    program = f"""
import signal, resource, os
from launcher.workspace.building.wheel.archive import WheelEntry, write
from launcher.base.errors import LauncherError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
try:
    write({str(target)!r}, [WheelEntry("p/big", os.urandom(10**6))], {INFO!r}, 315532800)
except LauncherError as error:
    print(error.message)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert "a.whl cannot be written: File too large" in done.stdout, done.stderr
    assert target.read_bytes() == old
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.whl", "größe.py"]
