"""The variables that colcon, CMake and the generators get."""

from __future__ import annotations

import os
import sys
import sysconfig
from collections.abc import Iterable, Mapping

from launcher.base.errors import LauncherError
from launcher.packages.finder import search_prefixes
from launcher.workspace.building.build_place import Place
from launcher.workspace.building.toolchain.compiler import Compiler

HOOK = os.path.join(os.path.dirname(os.path.abspath(__file__)), "wheels.cmake")
_PATHS = (
    "AMENT_PREFIX_PATH",
    "CMAKE_PREFIX_PATH",
    "COLCON_PREFIX_PATH",
    "LD_LIBRARY_PATH",
    "PATH",
    "PYTHONPATH",
)


def prepared(
    environ: Mapping[str, str], place: Place, compiler: Compiler | None = None
) -> dict[str, str]:
    """The environment of a build.

    The prefix with the wheels comes last, after prefixes that the user has sourced. The
    workspace's own `install/` is left out, since colcon adds what a package depends on.
    """
    env = dict(environ)
    for name in _PATHS:
        env[name] = _without(env.get(name, ""), place.install)
        if not env[name]:
            del env[name]
    prefixes = [str(path) for path in search_prefixes(env)]
    env["AMENT_PREFIX_PATH"] = os.pathsep.join(prefixes)
    env["CMAKE_PREFIX_PATH"] = _joined(env.get("CMAKE_PREFIX_PATH", ""), *prefixes)
    env["PATH"] = _joined(os.path.dirname(sys.executable), env.get("PATH", os.defpath))
    env["NINJA_STATUS"] = "[%f/%t] "
    env["LANGUAGE"] = "C"  # messages of compilers and linkers that `explain` matches
    if compiler is not None:
        env.update(compiler.variables)
    return env


def prefixes(environ: Mapping[str, str], place: Place) -> list[str]:
    """The prefixes with the packages that the workspace is built upon, that of the wheels last."""
    found = prepared(environ, place)["AMENT_PREFIX_PATH"].split(os.pathsep)
    # The launcher may have put the wheels before workspaces that only COLCON_PREFIX_PATH names.
    return sorted(found, key=lambda path: path == sys.prefix)


def cmake_args(compiler: Compiler | None, *, cpp: bool = False) -> list[str]:
    """The definitions for CMake that are the same for all packages.

    Interfaces are generated for C++ as well with `cpp`.
    """
    args = [
        "-GNinja",
        "-DBUILD_TESTING=OFF",
        "-DCMAKE_BUILD_TYPE=Release",
        f"-DCMAKE_PROJECT_INCLUDE={HOOK}",
        f"-DPython3_EXECUTABLE={sys.executable}",
        f"-DLAUNCHER_PYTHON_INCLUDE={sysconfig.get_path('include')}",
        f"-DLAUNCHER_NUMPY_INCLUDE={_numpy_include()}",
    ]
    if cpp:
        args.append("-DLAUNCHER_CPP=ON")
    return [*args, *(compiler.cmake_args if compiler else ())]


def require_python_headers() -> None:
    """LauncherError if the header files of the running Python are missing."""
    folder = sysconfig.get_path("include")
    if os.path.isfile(os.path.join(folder, "Python.h")):
        return
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    raise LauncherError(
        f"the header files of Python {version} are missing: {folder}/Python.h",
        hint=f"sudo apt-get install python{version}-dev; or use a Python that brings them, such as "
        "that of uv (uv python install) or pyenv",
    )


def _numpy_include() -> str:
    import numpy

    return str(numpy.get_include())


def _without(value: str, folder: str) -> str:
    parts = value.split(os.pathsep)
    return os.pathsep.join(one for one in parts if one and not _is_below(one, folder))


def _is_below(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder + os.sep)


def _joined(*values: str) -> str:
    parts: Iterable[str] = (one for value in values for one in value.split(os.pathsep) if one)
    return os.pathsep.join(dict.fromkeys(parts))
