"""Makes wheels of the packages of a workspace."""

from __future__ import annotations

import os
import posixpath
import shlex
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from launcher.base.errors import LauncherError, SeveralErrors, UsageError
from launcher.base.program import program
from launcher.base.text import did_you_mean
from launcher.workspace.building import records, sources
from launcher.workspace.building.build_place import Place
from launcher.workspace.building.sources import Package
from launcher.workspace.building.sources.source_text import shown
from launcher.workspace.building.toolchain import versions as tools
from launcher.workspace.building.wheel import (
    archive,
    contents,
    dist_info,
    libraries,
    python_package,
    requirements,
)
from launcher.workspace.building.wheel.archive import WheelEntry
from launcher.workspace.building.wheel.contents import WheelContents
from launcher.workspace.building.wheel.libraries import Library


@dataclass(frozen=True)
class Wheel:
    """A wheel that was written, or had the same bytes before."""

    path: str
    size: int
    is_new: bool
    warnings: tuple[str, ...]


def selected(
    place: Place, names: Sequence[str], environ: Mapping[str, str], *, alone: bool
) -> tuple[list[Package], dict[str, Package]]:
    """The named packages, all without names, and unless `alone` those that they need, and all
    packages of the workspace by name. UsageError for unknown ones and for those that cannot be
    read, LauncherError if a named one, or one that it needs, is not built.
    """
    found = sources.find([place.base], environ)
    packages = {package.name: package for package in found.packages}
    wanted = {*(names or packages)}
    if not alone:
        wanted = sources.with_dependencies(found.everything, wanted, "run")
    wrong = [one for one in found.errors if not names or one.package in wanted]
    unknown = [name for name in names if name not in packages]
    if unknown and not wrong:
        raise UsageError(
            f"no package '{unknown[0]}' in {shown(place.base)}",
            hint=did_you_mean(unknown[0], packages)
            or (f"its packages are {', '.join(sorted(packages))}" if packages else None),
        )
    if wrong:
        raise SeveralErrors(wrong)
    chosen = [package for package in sources.in_order(found.packages) if package.name in wanted]
    if names:
        _check_built(place, chosen)
    return chosen, packages


def _check_built(place: Place, packages: Sequence[Package]) -> None:
    errors = [
        LauncherError(
            f"{package.name} is not built", hint=f"{program()} build {shown(package.folder)}"
        )
        for package in packages  # a Python package is packed from its sources
        if not package.is_python and not contents.is_built(place, package.name)
    ]
    if errors:
        raise SeveralErrors(errors)


def make(
    place: Place,
    chosen: Sequence[Package],
    packages: Mapping[str, Package],
    output: str,
    environ: Mapping[str, str],
) -> Iterator[Wheel]:
    """Write a wheel of each package into the folder `output`.

    LauncherError, after all packages were tried.
    """
    seconds = archive.timestamp(environ.get("SOURCE_DATE_EPOCH"))
    try:
        os.makedirs(output, exist_ok=True)
    except FileExistsError:
        raise UsageError(f"{shown(output)} is not a folder", hint="--output names one") from None
    except OSError as error:
        raise LauncherError(
            f"{shown(output)} cannot be made: {os.strerror(error.errno or 0)}"
        ) from None
    installed = requirements.installed()
    errors = list[LauncherError]()
    for package in chosen:
        try:
            _check_built(place, [package])
            maker = _Maker(place, package, packages, installed, environ)
            wheel = maker.make(output, seconds)
        except LauncherError as error:
            errors.append(error)
        else:
            yield wheel
    if errors:
        raise SeveralErrors(errors)


class _Maker:
    """The wheel of one package."""

    def __init__(
        self,
        place: Place,
        package: Package,
        packages: Mapping[str, Package],
        installed: requirements.Installed,
        environ: Mapping[str, str],
    ) -> None:
        self._place = place
        self._package = package
        self._packages = packages
        self._installed = installed
        self._environ = environ
        self._warnings = list[str]()

    def make(self, output: str, seconds: int) -> Wheel:
        package = self._package
        fields = dist_info.fields_of(package)
        self._check_fresh()
        found, named = self._contents()
        modules, native = _with_libraries(found.modules, "lib/python/site-packages")
        data, more = _with_libraries(found.data, "")
        native += more
        needs = self._requirements(native, named)
        platform = self._platform(native) if native else "any"
        python = f"cp{found.python.replace('.', '')}" if found.python else "py3"
        tag = f"{python}-{python if found.python else 'none'}-{platform}"
        stem = dist_info.stem(fields)
        entries = [
            *modules,
            *(
                WheelEntry(f"{stem}.data/data/{one.name}", one.source, one.is_executable)
                for one in data
            ),
        ]
        self._check_paths(entries)
        legal = contents.legal_files(package)
        entries += dist_info.entries(fields, found, tag, needs, legal)
        path = os.path.join(output, f"{stem}-{tag}.whl")
        is_new = archive.write(path, entries, dist_info.dist_info(fields), seconds)
        return Wheel(path, os.path.getsize(path), is_new, tuple(self._warnings))

    def _check_fresh(self) -> None:
        """LauncherError if sources have changed since the build, of which `install/` has links.

        A warning if only the tools have. Nothing is known of what colcon alone has built.
        """
        package, place = self._package, self._place
        last = None if package.is_python else records.read(place, package.name)
        if last is None:
            return
        changes = records.source_changes(package, last, place)
        again = f"{program()} build {shown(package.folder)}"
        if changes:
            raise LauncherError(
                f"{package.name} has changed since it was built: {', '.join(changes[:3])}",
                hint=again,
            )
        if last["setting"]["tools"] != tools.fingerprint():
            self._warnings.append(f"built with other ROS wheels or tools than installed: {again}")

    def _contents(self) -> tuple[WheelContents, tuple[str, ...]]:
        if self._package.is_python:
            return python_package.contents(self._package)
        found = contents.installed(self._place, self._package)
        if found.left_out:
            self._warnings.append(
                f"environment hooks have no place in a wheel: {', '.join(found.left_out)}"
            )
        return found, ()

    def _requirements(self, native: Sequence[Library], named: Sequence[str]) -> tuple[str, ...]:
        needed = {name for library in native for name in library.needed}
        found = requirements.of_package(
            self._package, self._packages, self._installed, needed if native else None
        )
        elsewhere = requirements.in_workspaces(found.unknown, self._environ)
        for root, names in elsewhere.items():
            self._warnings.append(
                f"package.xml asks for {', '.join(names)} of another workspace, which pip will not "
                f"install without a wheel: {program()} wheel {' '.join(names)} --workspace "
                f"{shlex.quote(shown(root))}"
            )
        known = set().union(*elsewhere.values())
        unknown = [one for one in found.unknown if one not in known]
        if unknown:
            self._warnings.append(
                f"package.xml asks for {', '.join(unknown)}, which pip will not install: "
                "no ROS package of this environment or workspace"
            )
        return requirements.merged(found.words, named)

    def _platform(self, native: Sequence[Library]) -> str:
        known = {*self._installed.libraries}
        for name in self._packages:
            folder = os.path.join(contents.prefix_of(self._place, name), "lib")
            known.update(os.listdir(folder) if os.path.isdir(folder) else ())
        tag, reason = libraries.platform(native, known)
        if reason:
            self._warnings.append(f"the wheel fits machines like this one only: {reason}")
        return tag

    def _check_paths(self, entries: Sequence[WheelEntry]) -> None:
        """Warn of folders of this machine in the files."""
        folders = {os.path.realpath(self._place.root), self._place.root}
        if sys.prefix != sys.base_prefix:  # an environment; /usr is everywhere
            folders.add(sys.prefix)
        marks = [os.fsencode(folder + os.sep) for folder in folders]
        naming = [one.name for one in entries if any(mark in one.read() for mark in marks)]
        if naming:
            names = ", ".join(naming[:3]) + (", ..." if len(naming) > 3 else "")
            self._warnings.append(
                f"folders of this machine are named in {names}: made elsewhere, the wheel has "
                f"other bytes; {program()} build --all {shown(self._package.folder)}"
            )


def _with_libraries(
    entries: Iterable[WheelEntry], base: str
) -> tuple[list[WheelEntry], list[Library]]:
    """The entries, with libraries as they are to be installed below `base`, and these.

    A library that others need by another name than that of its file is there by both: the link that
    CMake makes for it is missing where files are installed as links.
    """
    found, native = dict[str, WheelEntry](), list[Library]()
    for entry in entries:
        if libraries.is_library(entry):
            folder = posixpath.dirname(entry.name)
            library = libraries.read(entry, posixpath.join(base, folder))
            native.append(library)
            entry = library.entry
            alias = posixpath.join(folder, library.soname)
            found.setdefault(alias, WheelEntry(alias, entry.source, entry.is_executable))
        found[entry.name] = entry
    return list(found.values()), native
