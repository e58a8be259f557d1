"""Waits for changes in folders, by watchfiles, and until they are over."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterable, Iterator

from watchfiles._rust_notify import RustNotify

from launcher.base.errors import LauncherError

STEP_MS = 50  # how often watchfiles reads the events of the kernel
QUIET_S = 0.2  # without another change
LONGEST_S = 2.0  # after the first change; then files that are quiet themselves do not wait any more
_LIMIT = "/proc/sys/fs/inotify/max_user_watches"
_INSTANCES = "/proc/sys/fs/inotify/max_user_instances"


class Folders:
    """The folders of some files; those that do not exist are waited for in the next one above."""

    def __init__(self, wake: threading.Event) -> None:
        self._wake = wake
        self._notify: RustNotify | None = None
        self._folders: dict[str, int] = {}
        self._files: set[str] = set()  # and all folders above them

    def watch(self, paths: Iterable[str]) -> None:
        """From now on watch the folders of these files; LauncherError if the kernel refuses."""
        files = {file for path in paths for file in (path, os.path.realpath(path))}
        folders = _folders_of(files)
        self._files = {above for file in files for above in _ancestry(file)}
        if folders == self._folders:
            return
        self.close()
        self._folders = folders
        try:
            self._notify = RustNotify(list(folders), False, False, 300, False, False)
        except (OSError, RuntimeError) as error:
            raise _refused(error) from None

    def wait(self, timeout_s: float) -> bool:
        """Whether something has happened to the files until the timeout, or `wake` is set."""
        if self._notify is None:
            self._wake.wait(timeout_s)
            return False
        found = self._notify.watch(STEP_MS, STEP_MS, max(1, int(timeout_s * 1000)), self._wake)
        return isinstance(found, set) and any(path in self._files for _, path in found)

    def close(self) -> None:
        if self._notify is not None:
            self._notify.close()
            self._notify = None


def _ancestry(path: str) -> Iterator[str]:
    yield path
    while (above := os.path.dirname(path)) != path:
        yield (path := above)


def _folders_of(files: Iterable[str]) -> dict[str, int]:
    """Folder -> inode: one that was deleted and made again is another."""
    found: dict[str, int] = {}
    for folder in {os.path.dirname(file) for file in files}:
        for above in _ancestry(folder):
            with contextlib.suppress(OSError):
                inode = os.stat(above).st_ino
                if os.access(above, os.R_OK):
                    found.setdefault(above, inode)
                break
    return found


def _refused(error: Exception) -> LauncherError:
    text = str(error)
    if "limit" in text:
        limit = _read(_LIMIT)
        return LauncherError(
            f"the limit of inotify watches is reached (fs.inotify.max_user_watches={limit})",
            hint="sudo sysctl fs.inotify.max_user_watches=524288",
        )
    if "Too many open files" in text:
        limit = _read(_INSTANCES)
        return LauncherError(
            f"the limit of inotify instances is reached (fs.inotify.max_user_instances={limit})",
            hint="sudo sysctl fs.inotify.max_user_instances=1024",
        )
    return LauncherError(text)


def _read(path: str) -> str:
    try:
        with open(path, encoding="ascii") as file:
            return file.read().strip()
    except OSError:
        return "?"


class Settling:
    """Changes that are not over yet. Times are those of one clock, in seconds.

    A file is written in several steps, and a checkout writes many files.
    """

    def __init__(self) -> None:
        self._last: dict[str, float] = {}
        self._first_s = 0.0

    def note(self, paths: Iterable[str], now: float) -> None:
        """These have changed."""
        for path in paths:
            if not self._last:
                self._first_s = now
            self._last[path] = now

    @property
    def busy(self) -> list[str]:
        """What is not over."""
        return list(self._last)

    @property
    def due_s(self) -> float | None:
        """When `take` may have something; None if nothing has changed."""
        if not self._last:
            return None
        all_are = max(self._last.values()) + QUIET_S
        one_is = min(self._last.values()) + QUIET_S
        return min(all_are, max(one_is, self._first_s + LONGEST_S))

    def take(self, now: float) -> list[str]:
        """What is over: everything, unless that takes too long."""
        due_s = self.due_s
        if due_s is None or now < due_s:
            return []
        over = [path for path, changed_s in self._last.items() if now >= changed_s + QUIET_S]
        for path in over:
            del self._last[path]
        self._first_s = now
        return over
