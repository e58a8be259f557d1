"""Outputs: the files and folders that a smoke command is to write, tried before anything starts."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from errno import EISDIR, ENOTDIR
from pathlib import Path

from launcher.errors import LauncherError, UsageError
from launcher.smoke.checks import together

# What a run writes into the folder for the evidence, by these names.
COPIED = ("events.jsonl", "plan.json", "launch.log")
MADE = ("graph.json", "graph.svg", "report.json", "expectations.yaml", *COPIED)
TOLD = ("smoke.log", "launcher.out", "probe.log")


def refuse_unwritable(
    *, artifacts: Path | None, junit: Path | None, baseline: Path | None, repeat: int = 1
) -> None:
    """Make the folders that are missing; LauncherError with everything that cannot be written."""
    wanted: list[tuple[str, Path | None, Callable[[Path], None]]] = [
        ("--artifacts", artifacts, lambda path: _try_folder(path, repeat)),
        ("--junit", junit, _try_file),
        ("--baseline", baseline, _try_file),
    ]
    errors: list[LauncherError] = []
    for option, path, attempt in wanted:
        try:
            if path is not None:
                attempt(path)
        except FileExistsError as error:
            errors.append(UsageError(f"{option} {path}: {error.strerror}, and is no folder"))
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
        path.unlink()  # a file that is empty would be taken for a result


def _try_folder(path: Path, repeat: int) -> None:
    path.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=path):
        pass
    for folder in (path,) if repeat == 1 else runs_in(path, repeat):
        for name in (*MADE, *TOLD):
            if (folder / name).is_dir():
                raise IsADirectoryError(EISDIR, os.strerror(EISDIR), str(folder / name))
        for place in (folder, folder / "log"):
            if place.exists() and not place.is_dir():
                raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR), str(place))


def runs_in(path: Path, repeat: int) -> Iterator[Path]:
    """The folders of several runs."""
    return (path / f"run-{number}" for number in range(1, repeat + 1))


def save(path: Path, text: str) -> None:
    """Write a whole file, or none: half of one would be taken for a result. OSError."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError:
        if path.is_file():
            path.unlink()
        raise
