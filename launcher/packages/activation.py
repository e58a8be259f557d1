"""Makes a workspace visible to this process, and so to all that it starts."""

from __future__ import annotations

import os
import re
import shlex
import sys
from collections.abc import Iterator

from launcher.base.program import program
from launcher.packages.environment import LIBRARIES, environment, packages
from launcher.packages.hooks import read_text
from launcher.packages.source_packages import MARKERS
from launcher.packages.workspace import Workspace

_GUARD = "_LAUNCHER_LIBRARIES_OF"  # the workspace for which this process was executed again

_has_new_libraries = False


def activate(workspace: Workspace, *, warns: bool = False) -> None:
    """Put the workspace into `os.environ` and `sys.path`; WorkspaceError.

    With `warns`, warn if its links lead into another workspace.
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
        _execute_again(workspace)  # the workspace contains a launcher


def load_libraries(workspace: Workspace) -> None:
    """Have the loader look into the workspace, which it does only when a process starts."""
    if _has_new_libraries:
        _execute_again(workspace)


def _execute_again(workspace: Workspace) -> None:
    os.environ[_GUARD] = workspace.install
    os.execv(sys.executable, sys.orig_argv)


def _python_path(environ: dict[str, str]) -> list[str]:
    return [path for path in environ.get("PYTHONPATH", "").split(os.pathsep) if path]


# In setup.sh: the `install/` that it was made for.
_BUILT = re.compile(r"^_colcon_prefix_chain_sh_COLCON_CURRENT_PREFIX=(/.*)$", re.MULTILINE)


def built_elsewhere(workspace: Workspace) -> str | None:
    """The root of another workspace that the links of this one lead to: it was moved or copied."""
    found = _BUILT.search(read_text(os.path.join(workspace.install, "setup.sh")) or "")
    if found is None or os.path.realpath(found[1]) == os.path.realpath(workspace.install):
        return None
    root = os.path.dirname(found[1])
    for name, prefix in packages(workspace.install).items():
        if any(target.startswith(f"{root}/") for _, target in _links(prefix, name)):
            return root
    return None


def dead_link(prefix: str, package: str) -> str | None:
    """What a link of an installed package leads to, though it does not exist; None if all do."""
    return next((path for link, path in _links(prefix, package) if not os.path.exists(link)), None)


def _links(prefix: str, package: str) -> Iterator[tuple[str, str]]:
    """(link, its target) for those that every linked package has."""
    for place in (os.path.join("share", package, "package.xml"), os.path.join(MARKERS, package)):
        link = os.path.join(prefix, place)
        if os.path.islink(link):
            yield link, os.readlink(link)
