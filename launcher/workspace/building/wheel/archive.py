"""Writes wheels: the same entries give the same bytes."""

from __future__ import annotations

import base64
import contextlib
import csv
import filecmp
import hashlib
import io
import os
import time
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass

from launcher.base.errors import LauncherError, UsageError
from launcher.workspace.building.sources.source_text import shown

_FIRST = 315532800  # 1980-01-01, the first time stamp of a ZIP file
_LAST = 4354819199  # 2107-12-31
_BLOCK = 1 << 20
_Moment = tuple[int, int, int, int, int, int]  # year to second


@dataclass(frozen=True)
class WheelEntry:
    """A file of a wheel; `source` is its content, or the path of a file with it."""

    name: str
    source: bytes | str
    is_executable: bool = False

    def read(self) -> bytes:
        if isinstance(self.source, bytes):
            return self.source
        with open(self.source, "rb") as file:
            return file.read()


def timestamp(text: str | None) -> int:
    """The time of all entries from the value of SOURCE_DATE_EPOCH; UsageError.

    It is 1980-01-01 if there is none.
    """
    if not text:
        return _FIRST
    try:
        return min(max(int(text), _FIRST), _LAST)
    except ValueError:
        raise UsageError(
            f"SOURCE_DATE_EPOCH is '{text}', not a number of seconds",
            hint="unset it, or set it to the time of the last commit: git log -1 --format=%ct",
        ) from None


def write(path: str, entries: Iterable[WheelEntry], dist_info: str, seconds: int) -> bool:
    """Write a wheel; False if there was one with the same bytes. `dist_info` is where RECORD is.

    LauncherError; an old wheel is replaced by a whole one or not at all.
    """
    partial = f"{path}.partial"
    try:
        with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as archive:
            _write_entries(archive, entries, dist_info, time.gmtime(seconds)[:6])
        is_new = not (os.path.isfile(path) and filecmp.cmp(partial, path, shallow=False))
        if is_new:
            os.replace(partial, path)
        return is_new
    except OSError as error:
        what = error.filename if error.filename not in (None, partial) else path
        raise LauncherError(
            f"{shown(what)} cannot be {'read' if what != path else 'written'}: "
            f"{os.strerror(error.errno or 0)}"
        ) from None
    finally:
        with contextlib.suppress(OSError):
            os.unlink(partial)


def _write_entries(
    archive: zipfile.ZipFile, entries: Iterable[WheelEntry], dist_info: str, moment: _Moment
) -> None:
    rows = []
    # The files that describe the wheel come last, as the specification recommends.
    for entry in sorted(entries, key=lambda one: (one.name.startswith(dist_info), one.name)):
        rows.append((entry.name, *_write_entry(archive, entry, moment)))
    record = f"{dist_info}/RECORD"
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([*rows, (record, "", "")])
    _write_entry(archive, WheelEntry(record, text.getvalue().encode()), moment)


def _write_entry(archive: zipfile.ZipFile, entry: WheelEntry, moment: _Moment) -> tuple[str, int]:
    """Digest and size, as RECORD has them."""
    info = zipfile.ZipInfo(entry.name, moment)
    info.compress_type = zipfile.ZIP_DEFLATED
    info.create_system = 3  # Unix, for the mode
    info.external_attr = (0o100755 if entry.is_executable else 0o100644) << 16
    digest, size = hashlib.sha256(), 0
    source = entry.source
    # From 2 GiB on, zipfile has to know before it writes that sizes take 64 bits.
    info.file_size = len(source) if isinstance(source, bytes) else os.path.getsize(source)
    with (
        io.BytesIO(source) if isinstance(source, bytes) else open(source, "rb") as file,
        archive.open(info, "w") as target,
    ):
        while block := file.read(_BLOCK):
            digest.update(block)
            size += len(block)
            target.write(block)
    return "sha256=" + base64.urlsafe_b64encode(digest.digest()).decode().rstrip("="), size
