"""The folder of an export: written again as a whole, and nothing of others is overwritten."""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
from collections.abc import Mapping

from launcher.base import strict_json
from launcher.base.errors import LauncherError, UsageError

LIST = ".launcher-export.json"  # what was written last, with digests
_NEW = ".launcher-export.new"  # a folder for all files until they take the places of the last ones


class Folder:
    """An output folder."""

    def __init__(self, path: str) -> None:
        self.path = path
        self._before = self._read_list()

    def check(self, files: Mapping[str, str]) -> None:
        """UsageError if writing would overwrite a file that was not exported, or was changed."""
        if os.path.lexists(self.path) and not os.path.isdir(self.path):
            raise UsageError(f"--out: '{self.path}' is not a folder")
        if self._before is None and self._has_entries():
            raise UsageError(
                f"--out: '{self.path}' has files that are not of an export",
                hint="name a new folder, or an empty one",
            )
        before = self._before or {}
        found = sorted(name for name in {*files, *before} if os.path.lexists(self._full(name)))
        foreign = [name for name in found if name not in before]
        self._refuse(foreign, "is not of the last export", "move it away")
        changed = [name for name in found if _digest_of(self._full(name)) != before.get(name)]
        self._refuse(
            changed, "was changed after the last export", "keep a copy elsewhere, remove it"
        )

    def _refuse(self, names: list[str], what: str, hint: str) -> None:
        if names:
            more = f" (and {len(names) - 1} more)" if len(names) > 1 else ""
            raise UsageError(
                f"--out: '{os.path.join(self.path, names[0])}' {what}{more}",
                hint=f"{hint}, or name another folder",
            )

    def write(self, files: Mapping[str, str]) -> None:
        """Write all files, and remove those of the last export that are not among them.

        LauncherError, with all as before, if there is no room for them.
        """
        contents = {name: text.encode(errors="surrogateescape") for name, text in files.items()}
        contents[LIST] = _list_of(files)
        was_there = os.path.isdir(self.path)
        try:
            for name, content in contents.items():
                self._write(os.path.join(_NEW, name), content)
            for name in {*(self._before or {})} - files.keys():
                self._remove(name)
            for name in contents:
                os.makedirs(os.path.dirname(self._full(name)), exist_ok=True)
                os.replace(self._full(os.path.join(_NEW, name)), self._full(name))
        except OSError as error:
            raise LauncherError(
                f"--out: cannot write '{error.filename or self.path}': {error.strerror}"
            ) from None
        finally:
            shutil.rmtree(self._full(_NEW), ignore_errors=True)
            if not was_there:
                with contextlib.suppress(OSError):  # it has what was exported
                    os.rmdir(self.path)

    # ---- files

    def _full(self, name: str) -> str:
        return os.path.join(self.path, name)

    def _has_entries(self) -> bool:
        try:
            return os.listdir(self.path) not in ([], [_NEW])  # of one that was killed
        except OSError:
            return False

    def _read_list(self) -> dict[str, str] | None:
        """Digests by name; None if there was no export."""
        try:
            with open(self._full(LIST), encoding="utf-8") as file:
                data: object = strict_json.loads(file.read())
        except (OSError, ValueError):
            return None
        files = data.get("files") if isinstance(data, dict) else None
        if not isinstance(files, dict):
            return None
        return {str(name): str(digest) for name, digest in files.items() if _is_inside(str(name))}

    def _write(self, name: str, content: bytes) -> None:
        path = self._full(name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(content)

    def _remove(self, name: str) -> None:
        """Remove a file, if it exists, and the folders that are empty then."""
        with contextlib.suppress(FileNotFoundError):
            os.remove(self._full(name))
        folder = os.path.dirname(name)
        with contextlib.suppress(OSError):  # it is not empty, or does not exist
            while folder:
                os.rmdir(self._full(folder))
                folder = os.path.dirname(folder)


def _is_inside(name: str) -> bool:
    return not os.path.isabs(name) and ".." not in name.split("/")


def _list_of(files: Mapping[str, str]) -> bytes:
    digests = {
        name: _digest(text.encode(errors="surrogateescape")) for name, text in sorted(files.items())
    }
    return (strict_json.packed({"files": digests}, indent=1) + "\n").encode()


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _digest_of(path: str) -> str | None:
    try:
        with open(path, "rb") as file:
            return _digest(file.read())
    except OSError:
        return None
