"""Makes a workspace visible to this process, and so to all that it starts."""

from __future__ import annotations

import os
import shlex
import sys

from launcher.base.program import program
from launcher.packages.environment import LIBRARIES, environment
from launcher.packages.links import built_elsewhere
from launcher.packages.workspace import Workspace

_GUARD = "_LAUNCHER_LIBRARIES_OF"  # the workspace for which this process was executed again

_has_new_libraries = False


def activate(workspace: Workspace, *, warns: bool = False) -> None:
    """Put the workspace into `os.environ` and `sys.path`; WorkspaceError.

    With `warns`, tell the user if its links lead into another workspace.
    """
    global _has_new_libraries
    found = environment(workspace, os.environ)
    changed = {name: value for name, value in found.items() if os.environ.get(name) != value}
    is_second = os.environ.pop(_GUARD, None) == workspace.install
    other = built_elsewhere(workspace) if warns and not is_second else None
    if other is not None:
        print(
            f"warning: {workspace.root} was built in {other}, and moved or copied from there: its "
            f"links still lead there\nhint: {program()} build {shlex.quote(workspace.root)}",
            file=sys.stderr,
        )
    os.environ.update(changed)
    new = [path for path in _python_path(changed) if path not in sys.path]
    sys.path[1:1] = new
    _has_new_libraries = LIBRARIES in changed and not is_second
    if any(os.path.isdir(os.path.join(path, "launcher")) for path in new) and not is_second:
        _execute_again(workspace)  # the workspace has a launcher of its own


def load_libraries(workspace: Workspace) -> None:
    """Have the loader look into the workspace, which it does only when a process starts."""
    if _has_new_libraries:
        _execute_again(workspace)


def _execute_again(workspace: Workspace) -> None:
    os.environ[_GUARD] = workspace.install
    os.execv(sys.executable, sys.orig_argv)


def _python_path(environ: dict[str, str]) -> list[str]:
    return [path for path in environ.get("PYTHONPATH", "").split(os.pathsep) if path]
