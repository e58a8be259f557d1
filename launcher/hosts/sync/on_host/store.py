"""The folder of a host that is synchronized: files by their hash, a lock, links that are switched.

releases/NUMBER-ID/    what was brought, and `.sync.json`, its list
venvs/KEY/             environments of Python, which releases share
incoming/HASH          files of an unfinished release
wheels/                wheels for environments that are made without a network
current                a link to the release in use
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import json
import os
import re
import shutil
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from typing import Any

RECORD = ".sync.json"
_NAME = re.compile(r"\d{6,}-[0-9a-f]{8}")
FULL = (errno.ENOSPC, errno.EDQUOT)


class Refusal(Exception):
    """The request cannot be carried out; `hint` says what to do."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.hint = hint


class HostStore:
    """`root` is absolute. Nothing is made before `lock`."""

    def __init__(self, root: str) -> None:
        self.root = root
        self.releases = os.path.join(root, "releases")
        self.venvs = os.path.join(root, "venvs")
        self.incoming = os.path.join(root, "incoming")
        self.wheels = os.path.join(root, "wheels")
        self.current = os.path.join(root, "current")
        self._lock = -1

    def lock(self, say: Callable[[str], None]) -> None:
        """Hold the lock until this process ends; `say` is called with the holder if it has to wait.

        Programs that it starts inherit the lock: pip may outlive it, and must end first.
        """
        for folder in (self.root, self.releases, self.venvs, self.incoming, self.wheels):
            os.makedirs(folder, mode=0o755, exist_ok=True)
        self._lock = os.open(os.path.join(self.root, ".lock"), os.O_RDWR | os.O_CREAT, 0o644)
        os.set_inheritable(self._lock, True)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            holder = os.pread(self._lock, 200, 0).decode(errors="replace") or "another process"
            say(f"waiting for {holder}, who synchronizes it")
            fcntl.flock(self._lock, fcntl.LOCK_EX)

    def sign(self, who: str) -> None:
        """Write who holds the lock."""
        os.ftruncate(self._lock, 0)
        since = time.strftime("%H:%M:%S")
        os.pwrite(self._lock, f"{who}, since {since}".encode(errors="replace")[:200], 0)

    def current_release(self) -> str | None:
        """The name of the release in use."""
        try:
            name = os.path.basename(os.readlink(self.current))
        except OSError:
            return None
        return name if os.path.isdir(os.path.join(self.releases, name)) else None

    def names(self) -> list[str]:
        """All complete releases, the oldest first."""
        try:
            found = os.listdir(self.releases)
        except OSError:
            return []
        named = (name for name in found if _NAME.fullmatch(name))
        return sorted(name for name in named if os.path.isfile(self.record_path(name)))

    def record_path(self, name: str) -> str:
        return os.path.join(self.releases, name, RECORD)

    def record(self, name: str) -> dict[str, Any]:
        """What is noted about a release; empty if that cannot be read."""
        try:
            with open(self.record_path(name), encoding="ascii") as file:
                found: dict[str, Any] = json.load(file)
        except (OSError, ValueError):
            return {}
        return found

    def changed_files(self, name: str) -> set[str]:
        """Files of a release that somebody has changed or removed there."""
        folder, changed = os.path.join(self.releases, name), set()
        for path, (_, size, stamp) in self.record(name).get("files", {}).items():
            try:
                found = os.lstat(os.path.join(folder, path))
            except OSError:
                changed.add(path)
                continue
            if (found.st_size, found.st_mtime_ns) != (size, stamp):
                changed.add(path)
        return changed

    def contents(self) -> dict[str, str]:
        """Hash -> path of a file here with this content, in any release or unfinished."""
        found: dict[str, str] = {}
        for name in self.names():
            changed = self.changed_files(name)
            for path, (digest, *_) in self.record(name).get("files", {}).items():
                if path not in changed:
                    found[digest] = os.path.join(self.releases, name, path)
        with contextlib.suppress(OSError):
            for digest in os.listdir(self.incoming):
                if digest[0] != ".":
                    found[digest] = os.path.join(self.incoming, digest)
        return found

    def receive(self, target: str, digest: str, blocks: Iterable[bytes], path: str) -> None:
        """Write a file and give it its name when it is complete; Refusal if it was changed.

        `path` is that of the operator, for messages.
        """
        partial = os.path.join(os.path.dirname(target), f".{os.getpid()}.partial")
        sha = hashlib.sha256()
        try:
            with open(partial, "wb") as file:
                for block in blocks:
                    sha.update(block)
                    file.write(block)
            if sha.hexdigest() != digest:
                raise Refusal(f"{path} was changed while it was sent", "repeat the command")
            os.replace(partial, target)
        finally:
            with contextlib.suppress(OSError):
                os.unlink(partial)

    def clear_incoming(self) -> None:
        with contextlib.suppress(OSError):
            for name in os.listdir(self.incoming):
                os.unlink(os.path.join(self.incoming, name))

    def keep_wheels(self, names: Iterable[str]) -> None:
        """Remove all wheels but these."""
        for name in {*os.listdir(self.wheels)} - {*names}:
            os.unlink(os.path.join(self.wheels, name))

    def free_bytes(self) -> int:
        """Free space where the folder is, or will be."""
        folder = self.root
        while not os.path.isdir(folder):
            folder = os.path.dirname(folder)
        found = os.statvfs(folder)
        return found.f_bavail * found.f_frsize

    def point(self, link: str, target: str) -> None:
        """Make a link, or switch it, in one step."""
        new = f"{link}.new"
        with contextlib.suppress(FileNotFoundError):
            os.unlink(new)
        os.symlink(target, new)
        os.replace(new, link)
        _flush_folder(os.path.dirname(link))


def remove_folder(path: str) -> None:
    """Remove a folder whose files and folders may be read-only."""
    with contextlib.suppress(FileNotFoundError):
        shutil.rmtree(path)


def flush(path: str) -> None:
    """Have the disk hold all that was written there, before something refers to it."""
    folder = os.open(path, os.O_RDONLY)
    try:
        import ctypes

        if ctypes.CDLL(None).syncfs(folder) != 0:
            os.sync()
    except (ImportError, OSError, AttributeError):
        os.sync()
    finally:
        os.close(folder)


def _flush_folder(path: str) -> None:
    folder = os.open(path, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


@contextlib.contextmanager
def disk_errors(workspace: HostStore) -> Iterator[None]:
    """Turn errors of the disk into a Refusal; a full disk is relieved of what was brought."""
    try:
        yield
    except OSError as error:
        if error.errno in FULL and workspace.root:
            with contextlib.suppress(OSError):
                workspace.clear_incoming()
            free = workspace.free_bytes() // 1_000_000
            raise Refusal(
                f"the disk is full there ({free} MB free below {workspace.root})",
                "make space there and repeat the command; the release in use was not changed",
            ) from None
        what = f": {error.filename}" if error.filename else ""
        raise Refusal(
            f"{error.strerror or error}{what}", "the release in use was not changed"
        ) from None
