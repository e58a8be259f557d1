"""Finds ROS packages and their executables.

The search order is: prefixes of `AMENT_PREFIX_PATH`, workspaces of `COLCON_PREFIX_PATH`, the prefix
of the running Python (with the ROS wheels), packages that are used from their source folder
(`sources`), and other installed Python distributions, whose `scripts` are executables.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from launcher.base.errors import ExecutableNotFoundError, PackageNotFoundError
from launcher.base.text import did_you_mean
from launcher.packages import once, source_packages
from launcher.packages.entry_points import programs
from launcher.packages.source_packages import MARKERS, OVERLAY_FOLDER

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.packages.dist_info import DistInfo
    from launcher.packages.overlay import Overlay


def search_prefixes(env: Mapping[str, str]) -> list[Path]:
    """Prefixes that may have an ament index, in search order."""
    candidates = [Path(p) for p in _split(env.get("AMENT_PREFIX_PATH"))]
    for workspace in _split(env.get("COLCON_PREFIX_PATH")):
        candidates += [Path(workspace), *_isolated_prefixes(Path(workspace))]
    candidates.append(Path(sys.prefix))
    return list(dict.fromkeys(candidates))


def package_prefix(name: str, env: Mapping[str, str]) -> Path:
    """The prefix whose ament index lists `name`; PackageNotFoundError if none does."""
    return _located(name, env)[0]


def share_directory(name: str, env: Mapping[str, str]) -> Path:
    """The share folder of the package; the top folder of its sources if that serves as such.

    Raises PackageNotFoundError.
    """
    return _located(name, env)[1]


def resource_prefix(kind: str, name: str, env: Mapping[str, str]) -> Path | None:
    """The prefix whose ament index has this resource; for packages that of `package_prefix`."""
    if not kind or not name or "/" in kind + name:
        return None
    if kind == "packages":
        try:
            return package_prefix(name, env)
        except PackageNotFoundError:
            return None
    index = Path(MARKERS).parent
    prefixes = search_prefixes(env)
    return next((prefix for prefix in prefixes if (prefix / index / kind / name).is_file()), None)


def own_package(name: str, env: Mapping[str, str]) -> Overlay | None:
    """The package as it is used from its source folder; None if it is installed, or not found."""
    return None if _indexed(name, env) is not None else _own(name)


def find_executable(package: str, executable: str, env: Mapping[str, str]) -> Path:
    """The program `executable` of `package`.

    Raises PackageNotFoundError or ExecutableNotFoundError. Whoever asks is about to run it, so this
    is the place that warns of interfaces that it needs and does not find.
    """
    prefix, _, source = _located(package, env)
    libexec = prefix / "lib" / package
    scripts = dict(programs(package)) if _is_overlay(libexec) else {}
    found = scripts.get(executable)
    if found is None and _is_program(libexec / executable):
        found = libexec / executable
    scripts = scripts or ({} if found else dict(programs(package)))
    found = found or scripts.get(executable)
    if found is not None:
        if source is not None and env is os.environ:  # the environment of nodes to be started
            from launcher.packages.unbuilt import warn_of_dependencies

            warn_of_dependencies(package, source, env)
        return found
    names = [*_executables(libexec), *scripts]
    own = own_package(package, env) if _is_overlay(libexec) else None
    where = (
        f"in the source folder '{own.source}'" if own else f"on the libexec directory '{libexec}'"
    )
    raise ExecutableNotFoundError(
        f"executable '{executable}' not found {where}",
        hint=did_you_mean(executable, names) or _executables_hint(package, names, env),
    )


def executables(package: str, env: Mapping[str, str]) -> list[str]:
    """Names of all executables of `package`, sorted; PackageNotFoundError."""
    return sorted(executable_paths(package, env))


def executable_paths(package: str, env: Mapping[str, str]) -> dict[str, Path]:
    """Name -> path of all executables of `package`; PackageNotFoundError."""
    libexec = package_prefix(package, env) / "lib" / package
    paths = {name: libexec / name for name in _executables(libexec)}
    return {**paths, **dict(programs(package))}


def files_in_share(share: str | os.PathLike[str]) -> list[str]:
    """The files below a share folder; of a source folder, without what was built in it."""
    folder = os.fspath(share)
    if any(os.path.isfile(os.path.join(folder, name)) for name in ("setup.py", "CMakeLists.txt")):
        from launcher.packages import source_packages

        return list(source_packages.files_in(folder))
    return sorted(
        os.path.join(below, name) for below, _, names in os.walk(folder) for name in names
    )


def package_names(env: Mapping[str, str]) -> set[str]:
    """All packages that can be found, those used from their source folder included."""
    indexed = {
        path.name for prefix in search_prefixes(env) for path in (prefix / MARKERS).glob("*")
    }
    return indexed | {*source_packages.editable()} | {name for name, _ in source_packages.around()}


# ---- where a package is


def _located(name: str, env: Mapping[str, str]) -> tuple[Path, Path, str | None]:
    """(prefix, share folder, source folder if it is linked or used); PackageNotFoundError."""
    prefix = _indexed(name, env)
    if prefix is not None:
        manifest = f"{prefix}/share/{name}/package.xml"
        is_built = os.path.islink(manifest)  # in a workspace
        source = os.path.dirname(os.path.realpath(manifest)) if is_built else None
        return prefix, prefix / "share" / name, source
    own = _own(name)
    if own is not None:
        from launcher.packages.overlay import announce

        if env is os.environ:  # the environment of nodes that will be started
            announce(own.prefix)
        return Path(own.prefix), Path(own.share), own.source
    inherited = _indexed(name, env, inherited=True)
    if inherited is not None:
        return inherited, inherited / "share" / name, None
    prefix = _distribution_prefix(name)
    if prefix is None:
        from launcher.packages.unknown import package_not_found

        raise package_not_found(name, package_names(env), search_prefixes(env))
    return prefix, prefix / "share" / name, None


def _indexed(name: str, env: Mapping[str, str], *, inherited: bool = False) -> Path | None:
    """The prefix with this package; overlays are `inherited` from a launcher around this one."""
    for prefix in search_prefixes(env):
        if (prefix / MARKERS / name).is_file() and _is_overlay(prefix) == inherited:
            return prefix
    return None


def _is_overlay(path: Path) -> bool:
    return OVERLAY_FOLDER in str(path)


def _own(name: str) -> Overlay | None:
    return once(f"own {name}", lambda: _new_own(name))


def _new_own(name: str) -> Overlay | None:
    source = source_packages.find(name)
    if source is None:
        return None
    from launcher.packages import overlay

    scripts = {script: str(path) for script, path in programs(name)}
    libexec = Path(sys.prefix, "lib", name)
    installed = {program: str(libexec / program) for program in _executables(libexec)}
    return overlay.of(name, source, {**installed, **scripts})


def _distribution_prefix(name: str) -> Path | None:
    """The prefix of an installed distribution that has no entry in the index."""
    found = [each for each in source_packages.distributions(name) if not _is_in_build(each)]
    for distribution in found:
        for file in distribution.whole.files or ():
            before, share, _ = file.as_posix().partition(f"share/{name}/")
            if share and not before.strip("./"):
                return Path(os.path.normpath(str(distribution.whole.locate_file(before or "."))))
    return Path(sys.prefix) if found else None


def _is_in_build(distribution: DistInfo) -> bool:
    """Whether it is in the build folder of a package whose source, or installation, is gone."""
    return source_packages.is_built_in(distribution.folder)


def _split(value: str | None) -> list[str]:
    return [part for part in (value or "").split(os.pathsep) if part]


def _isolated_prefixes(workspace: Path) -> Iterator[Path]:
    """Prefixes in a colcon workspace with isolated layout, which is the default."""
    try:
        entries = sorted(workspace.iterdir())
    except OSError:
        return
    for entry in entries:
        if (entry / MARKERS / entry.name).is_file():
            yield entry


# ---- programs


def _is_program(path: Path) -> bool:
    return path.is_file() and os.access(path, os.X_OK)


def _executables(libexec: Path) -> list[str]:
    try:
        return [path.name for path in libexec.iterdir() if _is_program(path)]
    except OSError:
        return []


def _executables_hint(package: str, names: list[str], env: Mapping[str, str]) -> str:
    from launcher.packages.unknown import no_executable_hint

    own = None if names else own_package(package, env)
    source, problem = (None, None) if own is None else (own.source, own.contents.problem)
    return no_executable_hint(package, names, source, problem)
