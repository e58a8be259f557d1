"""Where the bag of an incident is: attached to its page, beside it, or where it was recorded."""

from __future__ import annotations

import base64
import io
import os
import shutil
import zipfile
from dataclasses import dataclass
from urllib.parse import quote

from launcher.bag.quantity_texts import size
from launcher.faults.incident.document import IncidentDocument, IncidentError
from launcher.faults.incident.markup import Markup, section, tag
from launcher.faults.incident.run_folder import RunFolder

_WORTH_TRYING = 3  # a bag that is so many times as large as the room hardly fits when compressed
_EPOCH = (1980, 1, 1, 0, 0, 0)  # of zip files


@dataclass(frozen=True, slots=True, kw_only=True)
class BagPlace:
    """`archive` is a zip of it that the page holds; `beside` its folder beside the page."""

    path: str
    total: int  # bytes
    archive: bytes | None = None
    beside: str | None = None

    def markup(self, name: str) -> Markup:
        """The section about it; `name` is that of the page without its ending."""
        origin = tag("code", self.path)
        if self.archive is not None:
            words: list[object] = [
                self._download(f"{name}-bag.zip"),
                f" ({size(len(self.archive))}), ",
            ]
            words += ["in this file; recorded as ", origin]
        elif self.beside is not None:
            words = ["Beside this file: ", tag("a", self.beside, href=f"./{quote(self.beside)}")]
            words += ["; recorded as ", origin]
        else:
            words = [f"It is too large for this file ({size(self.total)}), and is in ", origin]
        play = tag("code", "launcher bag play FOLDER")
        return section("bag", "Bag", tag("p", *words), tag("p", "To play it: ", play))

    def _download(self, name: str) -> Markup:
        data = base64.b64encode(self.archive or b"").decode()
        link = f"data:application/zip;base64,{data}"
        return tag("a", name, download=name, href=Markup(link))


def find(incident: IncidentDocument, folder: RunFolder | None) -> str | None:
    """The bag of the snapshot, or that of the whole run."""
    found = []
    if incident.snapshot is not None:
        found.append(os.path.join(incident.snapshot, "bag"))
        if folder is not None:  # the folder of the run may have been moved
            name = os.path.basename(os.path.normpath(incident.snapshot))
            found.append(folder.file("snapshots", name, "bag"))
    if folder is not None:
        found.append(folder.file("bag"))
    return next((path for path in found if os.path.isdir(path)), None)


def place(path: str, room: int, beside: str | None) -> BagPlace:
    """Attach the bag if it fits into `room` bytes; with `beside`, a path, copy it there.

    IncidentError if that cannot be done.
    """
    total = sum(os.path.getsize(file) for file in _files(path))
    if beside is not None:
        _copy(path, beside)
        return BagPlace(path=path, total=total, beside=os.path.basename(beside))
    archive = _zipped(path) if 0 < total < room * _WORTH_TRYING else None
    fits = archive is not None and len(archive) * 4 / 3 + 1000 < room
    return BagPlace(path=path, total=total, archive=archive if fits else None)


def _files(path: str) -> list[str]:
    found = [os.path.join(at, name) for at, _, names in os.walk(path) for name in names]
    return sorted(file for file in found if os.path.isfile(file) and not os.path.islink(file))


def _copy(path: str, target: str) -> None:
    if os.path.exists(target):
        raise IncidentError(f"{target} exists", hint="remove it, or choose another name with -o")
    try:
        shutil.copytree(path, target)
    except (OSError, shutil.Error) as error:
        raise IncidentError(f"cannot copy the bag to {target}: {error}") from None


def _zipped(path: str) -> bytes | None:
    """The same for the same files; None if they cannot be read."""
    buffer = io.BytesIO()
    try:
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in _files(path):
                name = os.path.relpath(file, path).encode(errors="replace").decode()
                entry = zipfile.ZipInfo(f"bag/{name}", _EPOCH)
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = 0o644 << 16
                with open(file, "rb") as content:
                    archive.writestr(entry, content.read())
    except (OSError, zipfile.LargeZipFile):
        return None
    return buffer.getvalue()
