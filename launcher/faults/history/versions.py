"""What was run: a hash of the files of a launch, and their commit. Neither fails, nor hangs."""

from __future__ import annotations

import contextlib
import hashlib
import os
import signal
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass

GIT_S = 2.0
MAX_BYTES = 16 * 1024 * 1024  # of a file, so that one without an end is not read for ever
_BLOCK = 256 * 1024
# No lock, no question for a password, and no program that the settings of a repository name.
_GIT = ("git", "-c", "core.fsmonitor=false", "-c", "core.pager=cat")
_GIT_ENV = {"GIT_OPTIONAL_LOCKS": "0", "GIT_TERMINAL_PROMPT": "0", "LC_ALL": "C"}


@dataclass(frozen=True, slots=True)
class FilesVersion:
    """`files_hash`: sha256 in hex, None if no file could be read; `git`: as `git describe`."""

    files_hash: str | None
    git: str | None

    def __str__(self) -> str:
        short = "" if self.files_hash is None else self.files_hash[:8]
        return " ".join(filter(None, (short, self.git))) or "unknown"


def of_launch(launch_file: str, others: Iterable[str] = ()) -> FilesVersion:
    """The version of a launch file, and of `others` that it has included or read."""
    return FilesVersion(hash_of([launch_file, *others]), described(os.path.dirname(launch_file)))


def hash_of(paths: Iterable[str]) -> str | None:
    """One hash of the contents of regular files, in any order of the paths."""
    hashes = sorted(filter(None, (_content(path) for path in set(paths))))
    if not hashes:
        return None
    if len(hashes) == 1:
        return hashes[0]  # as `sha256sum FILE`
    return hashlib.sha256("".join(hashes).encode()).hexdigest()


def _content(path: str) -> str | None:
    left, found = MAX_BYTES, hashlib.sha256()
    try:
        if not os.path.isfile(path):  # a pipe would not end
            return None
        with open(path, "rb") as file:
            while left > 0 and (block := file.read(min(_BLOCK, left))):
                found.update(block)
                left -= len(block)
    except (OSError, ValueError):
        return None
    return found.hexdigest()


def described(folder: str, timeout_s: float = GIT_S) -> str | None:
    """`v1.2-3-gabc1234-dirty`: the commit of a folder; None if it has none, or git takes longer."""
    words = (*_GIT, "-C", folder or ".", "describe", "--always", "--dirty")
    try:
        process = subprocess.Popen(
            words,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **_GIT_ENV},
            start_new_session=True,
        )
    except (OSError, ValueError):  # there is no git, or no such folder
        return None
    try:
        output, _ = process.communicate(timeout=timeout_s)
    except subprocess.TimeoutExpired:
        _kill(process)
        return None
    text = output.decode(errors="replace").strip()
    return text[:200] if process.returncode == 0 and text else None


def _kill(process: subprocess.Popen[bytes]) -> None:
    """With what it has started; not waiting for the end of its output."""
    with contextlib.suppress(OSError):
        os.killpg(process.pid, signal.SIGKILL)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(1.0)
    if process.stdout is not None:
        process.stdout.close()
