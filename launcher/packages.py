"""Finds ROS packages and their executables.

The search order is: prefixes of `AMENT_PREFIX_PATH`, workspaces of `COLCON_PREFIX_PATH`, the prefix
of the running Python (with the ROS wheels), installed Python distributions (whose console scripts
are executables), and the source tree that contains the working directory.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from launcher.errors import ExecutableNotFoundError, PackageNotFoundError
from launcher.text import did_you_mean

TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.metadata import Distribution

_MARKERS = "share/ament_index/resource_index/packages"


def search_prefixes(env: Mapping[str, str]) -> list[Path]:
    """Prefixes that may have an ament index, in search order."""
    candidates = [Path(p) for p in _split(env.get("AMENT_PREFIX_PATH"))]
    for workspace in _split(env.get("COLCON_PREFIX_PATH")):
        candidates += [Path(workspace), *_isolated_prefixes(Path(workspace))]
    candidates.append(Path(sys.prefix))
    return list(dict.fromkeys(candidates))


def package_prefix(name: str, env: Mapping[str, str]) -> Path:
    """The prefix whose ament index lists `name`; PackageNotFoundError if none does."""
    for prefix in search_prefixes(env):
        if (prefix / _MARKERS / name).is_file():
            return prefix
    if _distributions(name) or _source_tree(name) is not None:
        return Path(sys.prefix)
    raise _package_not_found(name, env)


def share_directory(name: str, env: Mapping[str, str]) -> Path:
    """The share folder of the package; the top folder of its sources if it is not installed.

    Raises PackageNotFoundError.
    """
    for prefix in search_prefixes(env):
        if (prefix / _MARKERS / name).is_file():
            return prefix / "share" / name
    source = _source_tree(name)
    if source is not None:
        return source
    if _distributions(name):
        return Path(sys.prefix) / "share" / name
    raise _package_not_found(name, env)


def find_executable(package: str, executable: str, env: Mapping[str, str]) -> Path:
    """The program `executable` of `package`.

    Raises PackageNotFoundError or ExecutableNotFoundError.
    """
    libexec = package_prefix(package, env) / "lib" / package
    program = libexec / executable
    if program.is_file() and os.access(program, os.X_OK):
        return program
    scripts = dict(_console_scripts(package))
    if executable in scripts:
        return scripts[executable]
    names = [*_programs(libexec), *scripts]
    listed = ", ".join(sorted(names)) or "none"
    raise ExecutableNotFoundError(
        f"executable '{executable}' not found on the libexec directory '{libexec}'",
        hint=did_you_mean(executable, names) or f"executables of {package}: {listed}",
    )


def executables(package: str, env: Mapping[str, str]) -> list[str]:
    """Names of all executables of `package`, sorted; PackageNotFoundError."""
    libexec = package_prefix(package, env) / "lib" / package
    return sorted({*_programs(libexec), *(name for name, _ in _console_scripts(package))})


def _split(value: str | None) -> list[str]:
    return [part for part in (value or "").split(os.pathsep) if part]


def _isolated_prefixes(workspace: Path) -> Iterator[Path]:
    """Prefixes in a colcon workspace with isolated layout, which is the default."""
    try:
        entries = sorted(workspace.iterdir())
    except OSError:
        return
    for entry in entries:
        if (entry / _MARKERS / entry.name).is_file():
            yield entry


def _programs(libexec: Path) -> list[str]:
    try:
        return [p.name for p in libexec.iterdir() if p.is_file() and os.access(p, os.X_OK)]
    except OSError:
        return []


def _distributions(name: str) -> list[Distribution]:
    """Installed distributions of this name.

    There may be two: an egg-info without files in the source tree, and what is installed from it.
    """
    # Takes 20 ms to import, and is needed only for packages outside of the index.
    from importlib import metadata

    return list(metadata.distributions(name=name))


def _console_scripts(package: str) -> Iterator[tuple[str, Path]]:
    """(name, path) of the console scripts of distributions with this name."""
    for distribution in _distributions(package):
        names = {e.name for e in distribution.entry_points if e.group == "console_scripts"}
        for file in distribution.files or ():
            path = Path(os.path.normpath(str(distribution.locate_file(file))))
            if path.name in names and path.parent.name == "bin" and path.is_file():
                yield path.name, path


def _source_tree(name: str) -> Path | None:
    """The working directory, a folder above it, or ours, if its package.xml has this name."""
    tag = f"<name>{name}</name>"
    here = Path(__file__).resolve().parent
    for folder in (Path.cwd(), *Path.cwd().parents, here.parent):
        manifest = folder / "package.xml"
        if manifest.is_file() and tag in manifest.read_text(encoding="utf-8", errors="replace"):
            return folder
    return None


def _package_not_found(name: str, env: Mapping[str, str]) -> PackageNotFoundError:
    prefixes = search_prefixes(env)
    known = {path.name for prefix in prefixes for path in (prefix / _MARKERS).glob("*")}
    searched = ", ".join(map(str, prefixes))
    return PackageNotFoundError(
        f"package '{name}' not found",
        hint=did_you_mean(name, known) or f"searched: {searched}",
    )
