"""Packages: where a ROS package lives, and which program one of its executables is.

Looked for in this order: the prefixes of `AMENT_PREFIX_PATH`, the workspaces of
`COLCON_PREFIX_PATH`, the prefix of the running Python (where the ROS wheels are), installed
Python distributions (their console scripts are the executables), and the source tree that the
working directory is in.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from launcher.errors import ExecutableNotFoundError, PackageNotFoundError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.metadata import Distribution

_MARKERS = "share/ament_index/resource_index/packages"


def ament_environment(env: Mapping[str, str]) -> dict[str, str]:
    """What has to be set so that the wheels' packages are found; add it to `env`.

    The wheels install an ament index below `sys.prefix` and set no `AMENT_PREFIX_PATH`
    (CONFORMANCE 4.23). Whoever has set one means that one: launch files look into it.
    """
    if _split(env.get("AMENT_PREFIX_PATH")) or not os.path.isdir(f"{sys.prefix}/{_MARKERS}"):
        return {}
    return {"AMENT_PREFIX_PATH": sys.prefix}


def search_prefixes(env: Mapping[str, str]) -> list[Path]:
    """Every prefix that may hold an ament index, first match wins."""
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
    """The package's share folder; for a package that runs from its sources, their top folder.

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

    Raises PackageNotFoundError, or ExecutableNotFoundError that names the nearest one there is.
    """
    libexec = package_prefix(package, env) / "lib" / package
    program = libexec / executable
    if program.is_file() and os.access(program, os.X_OK):
        return program
    scripts = dict(_console_scripts(package))
    if executable in scripts:
        return scripts[executable]
    import difflib

    names = [*_programs(libexec), *scripts]
    near = difflib.get_close_matches(executable, names, n=1)
    listed = ", ".join(sorted(names)) or "none"
    raise ExecutableNotFoundError(
        f"executable '{executable}' not found on the libexec directory '{libexec}'",
        hint=f"did you mean '{near[0]}'?" if near else f"executables of {package}: {listed}",
    )


def executables(package: str, env: Mapping[str, str]) -> list[str]:
    """Names of all executables of `package`, sorted; PackageNotFoundError."""
    libexec = package_prefix(package, env) / "lib" / package
    return sorted({*_programs(libexec), *(name for name, _ in _console_scripts(package))})


def _split(value: str | None) -> list[str]:
    return [part for part in (value or "").split(os.pathsep) if part]


def _isolated_prefixes(workspace: Path) -> Iterator[Path]:
    """The packages of a colcon workspace that was built with its default isolated layout."""
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
    """Every installed distribution of this name.

    More than one: a source tree in the working directory has an egg-info that knows no files,
    beside what is really installed from it.
    """
    # importlib.metadata costs some 20 ms to import: only packages outside the index pay it.
    from importlib import metadata

    return list(metadata.distributions(name=name))


def _console_scripts(package: str) -> Iterator[tuple[str, Path]]:
    """(name, path) of the console scripts that distributions of this name installed."""
    for distribution in _distributions(package):
        names = {e.name for e in distribution.entry_points if e.group == "console_scripts"}
        for file in distribution.files or ():
            path = Path(os.path.normpath(str(distribution.locate_file(file))))
            if path.name in names and path.parent.name == "bin" and path.is_file():
                yield path.name, path


def _source_tree(name: str) -> Path | None:
    """The folder above (or at) the working directory or this file whose package.xml says `name`."""
    tag = f"<name>{name}</name>"
    here = Path(__file__).resolve().parent
    for folder in (Path.cwd(), *Path.cwd().parents, here.parent):
        manifest = folder / "package.xml"
        if manifest.is_file() and tag in manifest.read_text(encoding="utf-8", errors="replace"):
            return folder
    return None


def _package_not_found(name: str, env: Mapping[str, str]) -> PackageNotFoundError:
    import difflib

    prefixes = search_prefixes(env)
    known: set[str] = set()
    for prefix in prefixes:
        known.update(p.name for p in (prefix / _MARKERS).glob("*"))
    near = difflib.get_close_matches(name, sorted(known), n=1)
    searched = ", ".join(map(str, prefixes))
    return PackageNotFoundError(
        f"package '{name}' not found",
        hint=f"did you mean '{near[0]}'?" if near else f"searched: {searched}",
    )
