"""The environment of a workspace: what `. install/setup.sh` would set, read from colcon's data."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Mapping

from launcher.packages.hooks import Hooks, WorkspaceError, read_text
from launcher.packages.source_packages import MARKERS
from launcher.packages.workspace import MARKER, Workspace

LIBRARIES = "LD_LIBRARY_PATH"
_CHAIN = "COLCON_PREFIX_PATH"
_PACKAGES = "share/colcon-core/packages"
# In setup.sh: the prefixes that were in the environment of the build, the lowest first.
_CHAINED = re.compile(r'^COLCON_CURRENT_PREFIX="([^"$]+)"$', re.MULTILINE)


def environment(workspace: Workspace, environ: Mapping[str, str]) -> dict[str, str]:
    """`environ` with the workspace, and those that it was built on, in front; WorkspaceError.

    If the workspace was sourced last, entries that are there keep their places. The order of
    libraries is set in any case: the wheels' Python has shuffled it when it started.
    """
    return merged(read(workspace), environ, workspace.install)


def merged(hooks: Hooks, environ: Mapping[str, str], install: str) -> dict[str, str]:
    """`environ` with what the hooks set; `install` is the topmost prefix of these."""
    result = dict(environ)
    for name, (value, replaces) in hooks.values.items():
        if replaces or not result.get(name):
            result[name] = value
    is_sourced = _split(environ.get(_CHAIN))[:1] == [install]
    for name in dict.fromkeys((*hooks.front, *hooks.back)):
        there = _split(result.get(name))
        front, back = hooks.front.get(name, []), hooks.back.get(name, [])
        if is_sourced and name != LIBRARIES:
            front = [path for path in front if path not in there]
        rest = [path for path in there if path not in front]
        paths = [*front, *rest, *(path for path in back if path not in rest)]
        if paths != there:
            result[name] = os.pathsep.join(paths)
    return result


def read(workspace: Workspace) -> Hooks:
    """The hooks of all packages of a workspace and of those that it was built on."""
    if os.pathsep in workspace.install:
        raise WorkspaceError(
            f"a workspace cannot be in {workspace.root}: its path contains '{os.pathsep}', which "
            "separates the entries of AMENT_PREFIX_PATH",
            hint="rename the folder, and build again",
        )
    hooks = Hooks()
    for prefix in (*underlays(workspace), workspace.install):
        _read_prefix(prefix, hooks)
    return hooks


def underlays(workspace: Workspace) -> list[str]:
    """The prefixes that were sourced when the workspace was built, the lowest first."""
    text = read_text(os.path.join(workspace.install, "setup.sh")) or ""
    return [path for path in _CHAINED.findall(text) if path != workspace.install]


def of_build(workspace: Workspace, environ: Mapping[str, str]) -> dict[str, str]:
    """The environment in which a workspace is built again; WorkspaceError.

    That is `environ` with the prefixes that the last build was on, unless it names others itself.
    """
    below = underlays(workspace)
    known = tuple(f"{path}/" for path in (workspace.install, *below))
    named = {*_split(environ.get("AMENT_PREFIX_PATH")), *_split(environ.get(_CHAIN))} - {sys.prefix}
    if any(not f"{path}/".startswith(known) for path in named):
        return dict(environ)
    hooks = Hooks()
    for prefix in below:
        _read_prefix(prefix, hooks)
    return merged(hooks, environ, "")


def packages(install: str) -> dict[str, str]:
    """Package -> prefix of all that is installed in a prefix, dependencies first."""
    layout = (read_text(os.path.join(install, MARKER)) or "").strip()
    data, separator = _PACKAGES, ":"
    if layout == "isolated":
        prefixes = {name: os.path.join(install, name) for name in _names(install)}
        prefixes = {name: path for name, path in prefixes.items() if _is_listed(path, name)}
    elif layout == "merged" or os.path.isdir(os.path.join(install, _PACKAGES)):
        prefixes = dict.fromkeys(_names(os.path.join(install, _PACKAGES)), install)
    else:  # an installation of ROS 2, which was not made by colcon
        prefixes = dict.fromkeys(_names(os.path.join(install, MARKERS)), install)
        data, separator = os.path.join(os.path.dirname(MARKERS), "package_run_dependencies"), ";"
    files = {name: os.path.join(path, data, name) for name, path in prefixes.items()}
    return {name: prefixes[name] for name in _ordered(files, separator)}


def _read_prefix(prefix: str, hooks: Hooks) -> None:
    for package, below in packages(prefix).items():
        hooks.read_package(below, package)
    if os.path.isfile(os.path.join(prefix, "_local_setup_util_sh.py")):  # made by colcon
        hooks.prepend(_CHAIN, prefix)


def _is_listed(prefix: str, package: str) -> bool:
    return os.path.isfile(os.path.join(prefix, _PACKAGES, package))


def _names(folder: str) -> list[str]:
    try:
        return sorted(name for name in os.listdir(folder) if name[0] != ".")
    except FileNotFoundError:
        return []
    except OSError as error:
        raise WorkspaceError(f"{folder} cannot be read: {error.strerror}") from None


def _ordered(files: Mapping[str, str], separator: str) -> Iterator[str]:
    """The packages, each after those that it depends on; a file lists these."""
    left = {
        name: set((read_text(file) or "").split(separator)) & {*files} - {name}
        for name, file in files.items()
    }
    while left:
        # Where the data has a cycle, its first one goes first.
        name = next((name for name, needed in left.items() if not needed), next(iter(left)))
        del left[name]
        for needed in left.values():
            needed.discard(name)
        yield name


def _split(value: str | None) -> list[str]:
    return [part for part in (value or "").split(os.pathsep) if part]
