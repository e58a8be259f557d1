"""Colcon workspaces: the one that the working directory is in, or that a user has named.

This module is on the way to the first process of every launch: it only looks for the workspace.
`activation` makes its `install/` visible to this process and those that it starts.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

from launcher.base.errors import UsageError

MARKER = ".colcon_install_layout"  # colcon writes it into `install/`: isolated or merged
VARIABLE = "LAUNCHER_WORKSPACE"  # names a workspace, as --workspace does; empty: none


class Workspace:
    """A folder with an `install` that colcon has made; both are absolute paths."""

    def __init__(self, root: str, install: str) -> None:
        self.root = root
        self.install = install


def current(environ: Mapping[str, str] = os.environ) -> Workspace | None:
    """The workspace that --workspace or `LAUNCHER_WORKSPACE` names, else that of the working
    directory; UsageError if what is named is not a workspace.
    """
    path = environ.get(VARIABLE)
    if path is None:
        return find()
    return workspace_at(path) if path else None


def find(start: str = "") -> Workspace | None:
    """The nearest workspace that a folder, by default the working directory, is in."""
    try:
        start = absolute(start)
    except OSError:
        return None  # the working directory does not exist any more
    folder, below = start, ""
    while folder != below:
        install = os.path.join(folder, "install")
        if is_install(install) and _is_trusted(install, start):
            return _workspace(folder, "install")
        folder, below = os.path.dirname(folder), folder
    return None


def absolute(path: str = "") -> str:
    """The absolute path, through the links that the shell came by: `src` may be one.

    $PWD has these names, as for `pwd` and make; os.getcwd() has the real ones.
    """
    real = os.path.abspath(path)
    named = os.path.normpath(os.path.join(os.environ.get("PWD", ""), path))
    try:
        is_same = os.path.isabs(named) and os.path.samefile(named, real)
    except OSError:
        return real
    return named if is_same else real


def workspace_at(path: str) -> Workspace:
    """The workspace of a folder, or of its `install`, whatever the name of that; UsageError."""
    folder = absolute(os.path.expanduser(path))
    for root, name in ((folder, "install"), os.path.split(folder)):
        if is_install(os.path.join(root, name)):
            return _workspace(root, name)
    if not os.path.isdir(folder):
        what = "is not a folder" if os.path.lexists(folder) else "does not exist"
        raise UsageError(f"workspace '{path}' {what}", hint=_hint(folder))
    raise UsageError(
        f"'{path}' is not a workspace: it has no install/ that colcon has made", hint=_hint(folder)
    )


def _workspace(root: str, name: str) -> Workspace:
    """That of the real folder: by a link to it, its builds would look moved."""
    root = os.path.realpath(root)
    return Workspace(root, os.path.join(root, name))


def _hint(folder: str) -> str | None:
    from launcher.base.program import program

    nearest = find(folder) if os.path.exists(folder) else None
    if nearest is not None:
        return f"did you mean {nearest.root}?"
    if os.path.isdir(os.path.join(folder, "src")):
        return f"build it first: {program()} build --workspace {folder}"
    if os.path.isdir(folder):
        return "name the folder that has src/ and install/"
    from launcher.base.text import did_you_mean

    above, name = os.path.split(folder)
    is_file = os.path.lexists(folder)
    names = os.listdir(above) if os.path.isdir(above) and not is_file else []
    return did_you_mean(name, names) or f"it comes from --workspace, or from {VARIABLE}"


def is_install(folder: str) -> bool:
    """Whether a folder is the `install` of a workspace, whatever its name."""
    return os.path.isfile(os.path.join(folder, MARKER))


def _is_trusted(install: str, start: str) -> bool:
    """Whether the folder is of this user, of root, or of the owner of the working directory.

    In a folder that all may write to, such as /tmp, anybody could put an `install/` with programs.
    """
    try:
        return os.stat(install).st_uid in (os.geteuid(), 0, os.stat(start).st_uid)
    except OSError:
        return False  # it has just been removed
