"""Where new packages go, and writing them: all of them or none."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path

from launcher.base.errors import LauncherError, UsageError
from launcher.packages.workspace import VARIABLE
from launcher.workspace.building.sources.source_text import shown

_MANIFEST = "package.xml"


def destination(given: str | None) -> str:
    """The folder for new packages: the given one, `src/` of a workspace, or the working directory.

    UsageError if --workspace names no folder, or if it is within a package, where colcon does not
    look for others.
    """
    here = os.getcwd()
    workspace = os.environ.get(VARIABLE)
    if given is not None:
        folder = os.path.join(here, given)
    elif workspace:
        if not os.path.isdir(workspace):
            raise UsageError(f"workspace '{workspace}' is not a folder", hint=f"mkdir {workspace}")
        folder = os.path.join(workspace, "src")
    else:
        sources = os.path.join(here, "src")
        is_root = os.path.isdir(sources) and not os.path.exists(os.path.join(here, _MANIFEST))
        folder = sources if is_root else here
    folder = os.path.normpath(folder)
    for above in and_above(folder):
        if os.path.exists(os.path.join(above, _MANIFEST)):
            raise UsageError(
                f"{shown(folder)} is within the package {shown(above)}, "
                "and colcon finds no packages in packages",
                hint=f"cd {shown(os.path.dirname(above))}",
            )
        if os.path.exists(above) and not os.path.isdir(above):
            raise UsageError(f"{shown(above)} is not a folder")
    return folder


def sources_of_workspace(folder: str) -> str | None:
    """The folder `src` that the folder is, or is in; None: it is not in a workspace."""
    return next((above for above in and_above(folder) if os.path.basename(above) == "src"), None)


def existing(folder: str) -> str:
    """The folder, or the nearest above it that exists."""
    return next(above for above in and_above(folder) if os.path.isdir(above))


def check_free(folder: str, names: Iterable[str]) -> None:
    """UsageError if one of the packages has a file or folder already."""
    for name in names:
        path = os.path.join(folder, name)
        if os.path.lexists(path):
            raise UsageError(
                f"{shown(path)} exists already",
                hint="remove it or choose another name: nothing is overwritten",
            )


def write(folder: str, packages: Mapping[str, Mapping[str, str]]) -> None:
    """Write packages, name -> path -> text, below the folder; after an error nothing is left.

    Raises LauncherError.
    """
    made: list[str] = []
    try:
        for above in reversed(and_above(folder)):
            if not os.path.isdir(above):
                os.mkdir(above)
                made.append(above)
        drafts = [_write_draft(folder, name, texts, made) for name, texts in packages.items()]
        for draft, name in zip(drafts, packages, strict=True):
            path = os.path.join(folder, name)
            os.rename(draft, path)
            made.append(path)
    except BaseException as error:
        for path in reversed(made):
            shutil.rmtree(path, ignore_errors=True)
        if not isinstance(error, OSError):
            raise
        place = shown(error.filename or folder)
        raise LauncherError(f"nothing was created: {place}: {error.strerror}") from error


def _write_draft(folder: str, name: str, texts: Mapping[str, str], made: list[str]) -> str:
    """Write a package to a hidden folder, which becomes the package as a whole."""
    draft = os.path.join(folder, f".{name}.{os.getpid()}")
    os.mkdir(draft)
    made.append(draft)
    for path, text in texts.items():
        file = os.path.join(draft, path)
        os.makedirs(os.path.dirname(file), exist_ok=True)
        with open(file, "w", encoding="utf-8") as stream:
            stream.write(text)
    return draft


def and_above(folder: str) -> list[str]:
    """The folder and all above it."""
    return [folder, *map(str, Path(folder).parents)]
