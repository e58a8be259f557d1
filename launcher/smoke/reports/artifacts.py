"""Files and folders that a smoke command writes.

An evidence folder that was not asked for is kept only if something failed, and only the last ones.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from errno import EISDIR, ENOTDIR
from pathlib import Path

from launcher.base.document.document_reader import together
from launcher.base.errors import LauncherError, UsageError
from launcher.output.logs.old_runs import EVIDENCE
from launcher.output.logs.run_directory import log_root

KEPT = 20
_LOCK = ".in-use"
# The files of a run in its evidence folder.
COPIED = ("events.jsonl", "plan.json", "launch.log")
MADE = ("graph.json", "graph.svg", "report.json", "expectations.yaml", *COPIED)
LOGS = ("smoke.log", "launcher.out", "probe.log")


class Evidence:
    """The folder `path`; `is_kept`: keep it when the command is over."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.is_kept = True


@contextlib.contextmanager
def evidence(wanted: Path | None, env: Mapping[str, str] = os.environ) -> Iterator[Evidence]:
    """The wanted folder, or a new one beside the run folders."""
    if wanted is not None:
        yield Evidence(wanted)
        return
    root = Path(log_root(env), EVIDENCE)
    found = Evidence(_new(root))
    with _locked(found.path):
        try:
            yield found
        finally:
            if found.is_kept:
                print(f"smoke: the evidence is in {found.path} (the last {KEPT} stay)")
            else:
                shutil.rmtree(found.path, ignore_errors=True)
    prune(root)


def _new(root: Path) -> Path:
    stamp = time.strftime("%Y-%m-%d-%H-%M-%S")
    try:
        root.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(prefix=f"{stamp}-", dir=root))
    except OSError:
        return Path(tempfile.mkdtemp(prefix="smoke-"))  # as run folders do


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Keep other commands from removing the folder."""
    with (folder / _LOCK).open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    (folder / _LOCK).unlink(missing_ok=True)


def prune(root: Path) -> None:
    """Remove the oldest folders beyond `KEPT`, except those in use."""
    with contextlib.suppress(FileNotFoundError):
        folders = sorted(path for path in root.iterdir() if path.is_dir())
        for old in folders[: max(0, len(folders) - KEPT)]:
            if not _is_locked(old):
                shutil.rmtree(old, ignore_errors=True)


def _is_locked(folder: Path) -> bool:
    try:
        with (folder / _LOCK).open() as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


def refuse_unwritable(
    *,
    artifacts: Path | None,
    junit: Path | None,
    baseline: Path | None,
    record: Path | None = None,
    html: Path | None = None,
    repeat: int = 1,
) -> None:
    """Make missing folders, but for `record`; LauncherError with all that cannot be written."""
    wanted: list[tuple[str, Path | None, Callable[[Path], None]]] = [
        ("--artifacts", artifacts, lambda path: _try_folder(path, repeat)),
        ("--junit", junit, _try_file),
        ("--baseline", baseline, _try_file),
        ("--html", html, _try_file),
        ("--record", record, _try_replacement),
    ]
    errors: list[LauncherError] = []
    for option, path, attempt in wanted:
        try:
            if path is not None:
                attempt(path)
        except FileExistsError as error:
            errors.append(UsageError(f"{option} {path}: {error.strerror}, and is not a directory"))
        except OSError as error:
            of = error.filename if isinstance(error.filename, str) else ""
            at = f" ({of})" if of and not str(path).startswith(of) else ""
            errors.append(UsageError(f"{option} {path}: {error.strerror}{at}"))
    if errors:
        raise together(errors)


def _try_file(path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    is_new = not path.exists()
    with path.open("ab"):
        pass
    if is_new:
        path.unlink()  # an empty file would look like a result


def _try_replacement(path: Path) -> None:
    """A file that is written beside the path, and then takes its place.

    Folders that are missing are not left: maybe nothing will be written.
    """
    with _made(path.parent):
        if path.is_dir():
            raise IsADirectoryError(EISDIR, os.strerror(EISDIR), str(path))
        with tempfile.TemporaryDirectory(dir=os.path.dirname(os.path.realpath(path))):
            pass


@contextlib.contextmanager
def _made(folder: Path) -> Iterator[None]:
    """The folder, and those above it; those that are missing are removed again."""
    missing = [one for one in (folder, *folder.parents) if not os.path.lexists(one)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    finally:
        for one in missing:
            with contextlib.suppress(OSError):
                one.rmdir()


def _try_folder(path: Path, repeat: int) -> None:
    path.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=path):
        pass
    for folder in (path,) if repeat == 1 else runs_in(path, repeat):
        for name in (*MADE, *LOGS):
            if (folder / name).is_dir():
                raise IsADirectoryError(EISDIR, os.strerror(EISDIR), str(folder / name))
        for place in (folder, folder / "log"):
            if place.exists() and not place.is_dir():
                raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR), str(place))


def runs_in(path: Path, repeat: int) -> Iterator[Path]:
    return (path / f"run-{number}" for number in range(1, repeat + 1))


def discard(folder: Path) -> None:
    """Remove what a run has written that was refused before it began, and empty folders."""
    for name in LOGS:
        (folder / name).unlink(missing_ok=True)
    for path in (folder / "log", folder):
        with contextlib.suppress(OSError):  # it has something of another run
            path.rmdir()


def save(path: Path, text: str) -> None:
    """Write a whole file or none, since half of one would look like a result; OSError."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError:
        if path.is_file():
            path.unlink()
        raise
