"""The files of a release: where each one goes, and where its content comes from."""

from __future__ import annotations

import fnmatch
import hashlib
import os
import stat
from collections.abc import Iterator, Sequence
from typing import Any

from launcher.base import strict_json
from launcher.base.errors import LauncherError, SeveralErrors
from launcher.base.model.record import Record
from launcher.base.text import escape
from launcher.hosts.sync.on_host import wire

# Left out wherever they are: of version control, secrets, and what Python and editors make.
EXCLUDED = (
    *(".git", ".gitignore", ".gitattributes", ".gitmodules", ".hg", ".svn", ".env", ".env.*"),
    *("__pycache__", "*.pyc", ".pytest_cache", ".mypy_cache", ".ruff_cache", ".hypothesis"),
    *("*.egg-link", "easy-install.pth", "*~", ".*.sw[a-p]", ".DS_Store", ".netrc", ".ssh"),
)
_UNTOLD = ("__pycache__", ".pyc", ".egg-link", "easy-install.pth")  # they are made again, there


class TreeEntry(Record):
    """A file, from a `source` or with a `content`; or a link to `target`."""

    path: str
    source: str | None = None
    content: bytes | None = None
    target: str | None = None
    is_executable: bool = False

    def blocks(self) -> Iterator[bytes]:
        """The content, in blocks; OSError."""
        if self.source is None:
            yield self.content or b""
            return
        with open(self.source, "rb") as file:
            while block := file.read(wire.BLOCK_BYTES):
                yield block


class Tree:
    """Files by their path in the release. What is added first stays."""

    def __init__(self) -> None:
        self.entries: dict[str, TreeEntry] = {}
        self.left_out: dict[str, str] = {}  # file -> reason
        self._problems: list[LauncherError] = []

    def add(self, entry: TreeEntry) -> None:
        self.entries.setdefault(entry.path, entry)

    def add_text(self, path: str, text: str, *, is_executable: bool = False) -> None:
        content = text.encode("utf-8", "surrogateescape")
        self.add(TreeEntry(path=path, content=content, is_executable=is_executable))

    def add_file(self, path: str, source: str, roots: Sequence[str]) -> None:
        """Add a file, or what a link in one of the `roots` leads to."""
        if _is_excluded(os.path.basename(source)):
            self.left_out[source] = "never brought"
        elif self._is_safe(source, roots):
            found = os.stat(source)
            if stat.S_ISREG(found.st_mode):
                is_executable = bool(found.st_mode & 0o111)
                self.add(TreeEntry(path=path, source=source, is_executable=is_executable))
            else:
                self.left_out[source] = "no regular file"

    def add_folder(self, path: str, folder: str, roots: Sequence[str]) -> None:
        """Add all below a folder. Links within it stay links; others have to stay in `roots`."""
        self._walk(path, folder, folder, roots, (os.path.realpath(folder),))

    def take_problems(self, other: Tree) -> None:
        """Have the problems of another tree, too."""
        self._problems += other._problems

    def check(self) -> None:
        """LauncherError if there is a link that leads elsewhere."""
        if self._problems:
            raise SeveralErrors(self._problems)

    def _walk(
        self, path: str, folder: str, top: str, roots: Sequence[str], above: tuple[str, ...]
    ) -> None:
        with os.scandir(folder) as found:
            listed = sorted(found, key=lambda one: one.name)
        for one in listed:
            place = f"{path}/{one.name}"
            if _is_excluded(one.name):
                if not one.name.endswith(_UNTOLD):
                    self.left_out[one.path] = "never brought"
            elif one.is_symlink() and (target := _within(one.path, top)) is not None:
                self.add(TreeEntry(path=place, target=target))
            elif one.is_symlink() and not self._is_safe(one.path, roots):
                continue
            elif one.is_dir():
                real = os.path.realpath(one.path)
                if real not in above:
                    self._walk(place, one.path, top, roots, (*above, real))
            else:
                self.add_file(place, one.path, roots)

    def _is_safe(self, path: str, roots: Sequence[str]) -> bool:
        """Whether it exists, and is in one of the roots with all links followed."""
        real = os.path.realpath(path)
        if not os.path.exists(real):
            problem = f"{escape(path)} leads to {escape(real)}, which does not exist"
            hint = "remove the link, or build the package again"
        elif os.path.islink(path) and not any(_is_below(real, root) for root in roots):
            problem = f"{escape(path)} leads out of its package, to {escape(real)}"
            hint = "replace the link by a copy: what is outside is not brought to other hosts"
        else:
            return True
        self._problems.append(LauncherError(problem, hint=hint))
        return False


def _is_excluded(name: str) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in EXCLUDED)


def _is_below(path: str, root: str) -> bool:
    real = os.path.realpath(root)
    return path == real or path.startswith(os.path.join(real, ""))


def _within(link: str, top: str) -> str | None:
    """The target of a relative link that stays in the folder."""
    target = os.readlink(link)
    if os.path.isabs(target) or not os.path.exists(link):
        return None
    place = os.path.normpath(os.path.join(os.path.dirname(link), target))
    return target if place.startswith(os.path.join(top, "")) else None


class Release:
    """A tree with the hash of each file, as it is sent to hosts."""

    def __init__(self, entries: Sequence[TreeEntry]) -> None:
        """OSError if a file cannot be read."""
        self.rows: list[list[Any]] = []  # kind, path, hash or target, whether executable
        self.sizes: dict[str, int] = {}
        self.by_hash: dict[str, TreeEntry] = {}
        for entry in sorted(entries, key=lambda one: one.path):
            if entry.target is not None:
                self.rows.append(["link", entry.path, entry.target, False])
                continue
            digest, size = _measured(entry)
            self.rows.append(["file", entry.path, digest, entry.is_executable])
            self.sizes[digest] = size
            self.by_hash[digest] = entry

    @property
    def id(self) -> str:
        """What is the same for the same files at the same places."""
        return hashlib.sha256(strict_json.packed(self.rows).encode("ascii")).hexdigest()

    def with_entries(self, entries: Sequence[TreeEntry]) -> Release:
        """A release that has some more files; the others are not read again."""
        more = Release(entries)
        more.rows = sorted([*self.rows, *more.rows], key=lambda row: str(row[1]))
        more.sizes = {**self.sizes, **more.sizes}
        more.by_hash = {**self.by_hash, **more.by_hash}
        return more


def _measured(entry: TreeEntry) -> tuple[str, int]:
    sha, size = hashlib.sha256(), 0
    for block in entry.blocks():
        sha.update(block)
        size += len(block)
    return sha.hexdigest(), size
