"""What is installed: packages, interfaces and CMake configurations of the environment."""

from __future__ import annotations

import glob
import os
import sys
from collections.abc import Collection, Iterable, Mapping
from functools import cache, cached_property
from pathlib import Path

from launcher.packages.finder import search_prefixes
from launcher.packages.source_packages import MARKERS

_INTERFACES = os.path.join(os.path.dirname(MARKERS), "rosidl_interfaces")
_DEPENDENCIES = os.path.join(os.path.dirname(MARKERS), "package_run_dependencies")
# Where CMake looks for NAMEConfig.cmake below a prefix, besides `NAME_DIR`; it ignores the case of
# folders.
_CONFIG_FOLDERS = (
    "share/{0}/cmake", "share/{0}", "share/cmake/*", "lib/cmake/*", "lib/{0}*/cmake",
    "lib64/cmake/*", "lib/*-linux-gnu/cmake/*", "cmake", "{0}*/cmake", ".",
)  # fmt: skip
# With these CMake looks in places that are not known here.
_PLACES = {"CMAKE_FIND_ROOT_PATH", "CMAKE_MODULE_PATH", "CMAKE_PREFIX_PATH", "CMAKE_TOOLCHAIN_FILE"}
_REGISTRY = os.path.expanduser("~/.cmake/packages")


class Environment:
    """The packages outside of the workspace.

    `without` are folders whose prefixes do not count: the workspace's own `install/`.
    `definitions` are the names of what options define for CMake; with `is_merged` all packages
    have one prefix.
    """

    def __init__(
        self,
        env: Mapping[str, str] = os.environ,
        *,
        without: Iterable[str] = (),
        definitions: Collection[str] = (),
        is_merged: bool = False,
    ) -> None:
        own = [os.path.abspath(folder) for folder in without]
        self.prefixes = _outside(own, map(str, search_prefixes(env)))
        cmake = filter(None, env.get("CMAKE_PREFIX_PATH", "").split(os.pathsep))
        folders = [folder.rstrip("/") for folder in env.get("PATH", "").split(os.pathsep)]
        programs = [one for one in folders if os.path.basename(one) in ("bin", "sbin")]
        self._cmake_prefixes = _outside(
            own,
            [*self.prefixes, *cmake, "/usr/local", "/usr", *map(os.path.dirname, programs)],
        )
        named = (name for name in (*env, *definitions) if name.endswith(("_DIR", "_ROOT")))
        self._given = {name.rpartition("_")[0] for name in named}
        self.looks_elsewhere = bool(_PLACES & {*definitions}) or "CMAKE_TOOLCHAIN_FILE" in env
        self.is_merged = is_merged
        self.assumed: set[str] = set()  # packages to be taken as installed
        self.packages = {
            os.path.basename(path)
            for prefix in self.prefixes
            for path in glob.glob(os.path.join(glob.escape(prefix), MARKERS, "*"))
        }

    def has_cmake(self, name: str) -> bool:
        """Whether `find_package(name)` finds a configuration or a module of CMake."""
        is_known = name in self._given or name in self.assumed or name in _cmake_modules()
        return is_known or self._has_config(name) or os.path.isdir(f"{_REGISTRY}/{name}")

    def has_module(self, name: str) -> bool:
        """Whether an installed package has a module `FindNAME.cmake`, as those of vendors do."""
        pattern = os.path.join("share", "*", "cmake", "**", f"Find{glob.escape(name)}.cmake")
        prefixes = (os.path.join(glob.escape(prefix), pattern) for prefix in self.prefixes)
        return any(glob.glob(path, recursive=True) for path in prefixes)

    def _has_config(self, name: str) -> bool:
        files = (f"{name}Config.cmake", f"{name.lower()}-config.cmake")
        return any(
            glob.glob(os.path.join(glob.escape(prefix), folder.format(glob.escape(name)), file))
            for prefix in self._cmake_prefixes
            for folder in _CONFIG_FOLDERS
            for file in files
        )

    @cached_property
    def cmake_names(self) -> set[str]:
        """The packages of the index that `find_package` finds."""
        return {name for name in self.packages if self.has_cmake(name)}

    def interfaces(self, package: str) -> set[str]:
        """`msg/String`, ... of a package; empty if it has none."""
        for prefix in self.prefixes:
            try:
                with open(os.path.join(prefix, _INTERFACES, package), encoding="utf-8") as file:
                    return {os.path.splitext(line.strip())[0] for line in file if line.strip()}
            except OSError:
                continue
        return set()

    def run_dependencies(self, package: str) -> list[str]:
        """What a package of the index needs to run."""
        for prefix in self.prefixes:
            try:
                with open(os.path.join(prefix, _DEPENDENCIES, package), encoding="utf-8") as file:
                    return [name for name in file.read().strip().split(";") if name]
            except OSError:
                continue
        return []

    def interface_packages(self) -> set[str]:
        return {
            os.path.basename(path)
            for prefix in self.prefixes
            for path in glob.glob(os.path.join(glob.escape(prefix), _INTERFACES, "*"))
        }


def _outside(own: Iterable[str], prefixes: Iterable[str]) -> list[str]:
    """The prefixes that are not in one of the folders `own`, each once."""
    return [
        prefix
        for prefix in dict.fromkeys(prefixes)
        if not any(Path(os.path.abspath(prefix)).is_relative_to(folder) for folder in own)
    ]


@cache
def _cmake_modules() -> frozenset[str]:
    """The names for which CMake brings a module `FindNAME.cmake`."""
    roots = [
        *glob.glob(os.path.join(glob.escape(sys.prefix), "lib/python3*/site-packages/cmake/data")),
        "/usr/local", "/usr",
    ]  # fmt: skip
    found = (
        os.path.basename(path)[len("Find") : -len(".cmake")]
        for root in roots
        for path in glob.glob(os.path.join(root, "share/cmake-*/Modules/Find*.cmake"))
    )
    return frozenset(found)
