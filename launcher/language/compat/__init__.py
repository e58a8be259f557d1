"""Provides `launch`, `launch_ros` and their submodules to launch files.

The modules are made from a table by a meta-path finder that is active only inside `vocabulary()`:
other code imports an installed ROS 2, or a folder `launch/`, as usual.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType

import launcher.language.frontends  # noqa: F401 - gives the language its parsers
from launcher.language.compat import compat_table
from launcher.language.compat.names import (
    TEST_PACKAGES,
    PublicModule,
    is_of_tests,
    is_of_tool,
    is_public,
    submodules,
)
from launcher.language.launch_session import LaunchSession, open_sessions, replace_environment

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

TOP_NAMES = ("launch", "launch_ros", *TEST_PACKAGES, "launch_xml", "launch_yaml")
_FOLDER = os.path.dirname(__file__)
# Last on the path of Python (`setup.py`, and the plugin of pytest): modules that stand in for
# packages that are not installed, wherever no vocabulary is open.
ON_PATH = f"{_FOLDER}/on_path"


class _CompatFinder:
    """Finds and makes the modules of the table."""

    @staticmethod
    def find_spec(
        fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        top = fullname.partition(".")[0]
        if fullname == "ament_index_python.packages":
            spec: ModuleSpec | None = _ament().extended_spec(path)
            return spec
        if top not in TOP_NAMES or not is_public(fullname):
            return None
        if is_of_tests(top) and is_installed(top):
            return None
        return _CompatFinder.spec_of(fullname)

    @staticmethod
    def spec_of(fullname: str) -> ModuleSpec:
        spec = ModuleSpec(fullname, _CompatFinder, origin=compat_table.__file__)  # type: ignore[arg-type]
        if submodules(fullname):
            folder = f"{_FOLDER}/{fullname}"  # does not exist; listed by _Listing
            spec.submodule_search_locations = [folder]
            sys.path_importer_cache[folder] = _Listing(fullname)
        return spec

    @staticmethod
    def create_module(spec: ModuleSpec) -> ModuleType:
        return PublicModule(spec.name)

    @staticmethod
    def exec_module(module: PublicModule) -> None:
        module.__file__ = compat_table.__file__
        module.provide()


def is_installed(package: str) -> bool:
    """Whether the path has this package; a folder without `__init__.py` is none."""
    spec = PathFinder.find_spec(package, [entry for entry in sys.path if entry != ON_PATH])
    return spec is not None and spec.origin is not None


class _ToolFinder:
    """Finds modules of tools that are not installed; it is asked last."""

    @staticmethod
    def find_spec(
        fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        is_ours = is_of_tool(fullname) and is_public(fullname)
        return _CompatFinder.spec_of(fullname) if is_ours else None


class _Listing:
    """Lists the modules of a public package, for `pkgutil.iter_modules`."""

    def __init__(self, package: str) -> None:
        self._package = package

    def iter_modules(self, prefix: str = "") -> Iterator[tuple[str, bool]]:
        for name in sorted(submodules(self._package)):
            yield prefix + name, bool(submodules(f"{self._package}.{name}"))

    def find_spec(self, fullname: str, target: ModuleType | None = None) -> None:
        """None: the meta-path finder comes first."""


@contextmanager
def vocabulary(words: Sequence[str] | None = None) -> Iterator[LaunchSession]:
    """Make `import launch` import the launcher's own classes.

    May be nested. Keep it open for the whole run: functions of launch files may import later.
    The session yielded is for the driver, which may set the folder of the log files. `words`,
    the target and arguments of the command line, become `sys.argv` as under `ros2 launch`.
    Changes to modules, `sys.argv` and `os.environ` are undone on exit.
    """
    argv = sys.argv
    session = LaunchSession()
    if words is not None:
        sys.argv = _argv(words, session)
    open_sessions.append(session)
    saved = _take_modules()
    sys.modules.update(_tests_without_launch(saved))
    finder = _CompatFinder()
    sys.meta_path.insert(0, finder)
    sys.meta_path.append(_ToolFinder)
    if "ament_index_python" in sys.modules:
        _ament().extend_imported()
    try:
        yield session
    finally:
        replace_environment(session.environment)
        _reset_logging(session)
        open_sessions.remove(session)
        if not open_sessions and "launcher.language.compat.ament" in sys.modules:
            _ament().restore()
        sys.argv = argv
        sys.meta_path.remove(finder)
        sys.meta_path.remove(_ToolFinder)
        _take_modules()
        sys.modules.update(saved)


def _argv(words: Sequence[str], session: LaunchSession) -> list[str]:
    if len(words) < 2:
        return ["ros2", "launch", *words]
    from launcher.language.argv import Argv  # only where there are arguments

    return Argv(words, session.note_arguments_read)


def _ament() -> Any:
    from launcher.language.compat import ament  # few launch files need it

    return ament


def _reset_logging(session: LaunchSession) -> None:
    """Undo what a launch file has set in `launch.logging`, if any has loaded it."""
    log = sys.modules.get("launcher.language.logging.config")
    if log is not None and session is open_sessions[0]:
        session.is_script = True  # nothing runs any more
        with suppress(ValueError):
            log.reset()


def _take_modules() -> dict[str, ModuleType]:
    names = [name for name, module in sys.modules.items() if _is_ours(name, module)]
    return {name: sys.modules.pop(name) for name in names}


def _tests_without_launch(taken: dict[str, ModuleType]) -> dict[str, ModuleType]:
    """Installed packages of tests, which may be in the middle of their `import launch`."""
    if _is_foreign(taken.get("launch")):
        return {}
    return {
        name: module for name, module in taken.items() if is_of_tests(name) and _is_foreign(module)
    }


def _is_foreign(module: ModuleType | None) -> bool:
    file = getattr(module, "__file__", None)
    is_own = isinstance(module, PublicModule) or os.path.dirname(file or "") == ON_PATH
    return file is not None and not is_own


def _is_ours(name: str, module: ModuleType) -> bool:
    """Whether it has, or hides, a name of the vocabulary; an installed tool does not."""
    is_of_top = name.partition(".")[0] in TOP_NAMES
    return is_of_top or (is_of_tool(name) and isinstance(module, PublicModule))
