"""Interface packages of the surrounding `src/` that are not built.

Other packages can be used from their sources; messages are there only after a build.
"""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Mapping

from launcher.base.program import program
from launcher.packages import source_packages, workspace
from launcher.packages.source_packages import MARKERS

_checked: set[str] = set()
_warnings: list[str] = []


def hint(package: str, env: Mapping[str, str]) -> str | None:
    """What to do about the types of a package that are not found, if it has only to be built."""
    folder = next((folder for name, folder in source_packages.around() if name == package), None)
    if folder is None or not _is_unbuilt(package, folder, env):
        return None
    return f"{package} is in {folder}, and {remedy(package, folder)}"


def remedy(package: str, folder: str) -> str:
    """Where a package that is not found is built already, or how to build it."""
    root = _built_in(package, folder)
    return f"not built: {_build(folder)}" if root is None else f"built in {way_to(root)}"


def way_to(root: str) -> str:
    """A workspace that is not the current one, and how to use it: `./ws: cd ws, or ...`."""
    path, is_below = _shown(root)
    if workspace.VARIABLE in os.environ or _is_in(root):
        return f"{root}: --workspace {path}"  # another folder would change nothing
    return f"{'./' if is_below else ''}{path}: cd {path}, or --workspace {path}"


def _build(folder: str) -> str:
    """The command that builds the workspace of a source folder."""
    src = source_packages.src_of(folder)
    root = folder if src is None else os.path.dirname(src)
    is_found = _is_in(root) and not os.environ.get(workspace.VARIABLE)
    return f"{program()} build" + ("" if is_found else f" {_shown(root)[0]}")


def _is_in(root: str) -> bool:
    """Whether the working directory is in a folder."""
    return {*_from_here(root).split(os.sep)} <= {os.curdir, os.pardir}


def _from_here(root: str) -> str:
    try:
        return os.path.relpath(os.path.realpath(root))
    except OSError:  # the working directory does not exist any more
        return root


def _shown(root: str) -> tuple[str, bool]:
    """(a folder as a word for the shell, whether it is below the working directory)."""
    path = _from_here(root)
    is_below = path.partition(os.sep)[0] not in ("", os.curdir, os.pardir)
    return shlex.quote(path if is_below else root), is_below


def warn_of_dependencies(package: str, source: str, env: Mapping[str, str]) -> None:
    """Warn, once, if a package that is about to run needs interfaces that are not built."""
    if package in _checked:
        return
    _checked.add(package)
    others = source_packages.beside(source)
    needed: dict[str, str] = {}
    level = {package: source}
    while level:
        below = {name for folder in level.values() for name in source_packages.dependencies(folder)}
        level = {name: others[name] for name in below if name in others and name not in needed}
        needed |= level
    causes: dict[tuple[str, str], list[str]] = {}  # (what is wrong, hint) -> packages
    for name, folder in sorted(needed.items()):
        if _is_unbuilt(name, folder, env):
            root = _built_in(name, folder)
            cause = ("not built", _build(folder))
            if root is not None:
                cause = ("not found from this folder", f"it is built in {way_to(root)}")
            causes.setdefault(cause, []).append(name)
    for (what, way), names in causes.items():
        are = "is" if len(names) == 1 else "are"
        _warnings.append(
            f"warning: {package} needs {', '.join(names)}, which {are} {what}\nhint: {way}"
        )
        print(_warnings[-1], file=sys.stderr)


def repeat_warnings() -> None:
    """Print them again at the end of a run that has failed: they are its probable cause."""
    for warning in _warnings:
        print(warning, file=sys.stderr)


def _is_unbuilt(package: str, folder: str, env: Mapping[str, str]) -> bool:
    prefixes = [*env.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    # A moved workspace is here, too, but not the prefixes of its packages.
    for install in env.get("COLCON_PREFIX_PATH", "").split(os.pathsep):
        prefixes += [os.path.join(install, package)] if install else []
    return source_packages.has_interfaces(folder) and not any(
        _was_built(package, folder, prefix) for prefix in prefixes if prefix
    )


def _built_in(package: str, folder: str) -> str | None:
    """The workspace around a source folder if it has built the package; it need not be in use."""
    there = workspace.find(folder)
    prefixes = [] if there is None else [os.path.join(there.install, package), there.install]
    is_built = any(_was_built(package, folder, prefix) for prefix in prefixes)
    return there.root if there is not None and is_built else None


def _was_built(package: str, folder: str, prefix: str) -> bool:
    marker = os.path.join(prefix, MARKERS, package)
    if os.path.exists(marker) or not os.path.islink(marker):
        return os.path.isfile(marker)
    # The link leads to nowhere: in the workspace, its build folder was removed; out of it, the
    # workspace was moved, which is reported when it is activated.
    root = os.path.commonpath([os.path.abspath(prefix), folder])
    return not os.readlink(marker).startswith(os.path.join(root, ""))
