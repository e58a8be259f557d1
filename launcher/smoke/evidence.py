"""Evidence: the folder in which the runs of a smoke command leave what tells about them.

One that nobody asked for stays if something was not well: the last of them, as with run folders.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

from launcher.engine.logs.run_directory import log_root

KEPT = 20
_LOCK = ".in-use"


class Evidence:
    """`path` is the folder; `is_kept` is whether it is wanted once the command is over."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.is_kept = True


@contextlib.contextmanager
def evidence(wanted: Path | None, env: Mapping[str, str] = os.environ) -> Iterator[Evidence]:
    """The folder that is wanted, or one beside the run folders that goes if all was well."""
    if wanted is not None:
        yield Evidence(wanted)
        return
    root = log_root(env) / "smoke"
    found = Evidence(_new(root))
    with _held(found.path):
        try:
            yield found
        finally:
            if found.is_kept:
                print(f"smoke: the evidence is in {found.path}")
            else:
                shutil.rmtree(found.path, ignore_errors=True)
    prune(root)


def _new(root: Path) -> Path:
    stamp = time.strftime("%Y-%m-%d-%H-%M-%S")
    try:
        root.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(prefix=f"{stamp}-", dir=root))
    except OSError:
        return Path(tempfile.mkdtemp(prefix="smoke-"))  # a run folder has nowhere to be, either


@contextlib.contextmanager
def _held(folder: Path) -> Iterator[None]:
    """As long as this lasts, no other command removes the folder."""
    with (folder / _LOCK).open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    (folder / _LOCK).unlink(missing_ok=True)


def prune(root: Path, keep: int = KEPT) -> None:
    """Remove the oldest folders beyond `keep`; never one that is in use."""
    with contextlib.suppress(FileNotFoundError):
        folders = sorted(path for path in root.iterdir() if path.is_dir())
        for old in folders[: max(0, len(folders) - keep)]:
            if not _is_held(old):
                shutil.rmtree(old, ignore_errors=True)


def _is_held(folder: Path) -> bool:
    try:
        with (folder / _LOCK).open() as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False
