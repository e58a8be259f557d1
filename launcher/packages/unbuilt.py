"""Interface packages of the surrounding `src/` that are not built.

Other packages can be used from their sources; messages are there only after a build.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping

from launcher.base.program import program
from launcher.packages import source_packages
from launcher.packages.source_packages import MARKERS

_checked: set[str] = set()
_warnings: list[str] = []


def hint(package: str, env: Mapping[str, str]) -> str | None:
    """What to do about the types of a package that are not found, if it has only to be built."""
    folder = next((folder for name, folder in source_packages.around() if name == package), None)
    if folder is None or not _is_unbuilt(package, folder, env):
        return None
    return f"{package} is in {folder}, and not built: {program()} build"


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
    missing = sorted(name for name, folder in needed.items() if _is_unbuilt(name, folder, env))
    if missing:
        are = "is" if len(missing) == 1 else "are"
        _warnings.append(
            f"warning: {package} needs {', '.join(missing)}, which {are} not built\n"
            f"hint: {program()} build"
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


def _was_built(package: str, folder: str, prefix: str) -> bool:
    marker = os.path.join(prefix, MARKERS, package)
    if os.path.exists(marker) or not os.path.islink(marker):
        return os.path.isfile(marker)
    # The link leads to nowhere: in the workspace, its build folder was removed; out of it, the
    # workspace was moved, which is reported when it is activated.
    root = os.path.commonpath([os.path.abspath(prefix), folder])
    return not os.readlink(marker).startswith(os.path.join(root, ""))
