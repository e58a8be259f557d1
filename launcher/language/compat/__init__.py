"""`import launch` and `import launch_ros` inside a launch file: answered by our own language.

The modules are made from a table by a meta-path finder that is active inside of `vocabulary()`
and nowhere else, so that a real ROS 2, or the folder `launch/` of a workspace, is what it always
was for everybody else.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.machinery import ModuleSpec
from types import ModuleType

import launcher.frontends  # noqa: F401 - gives the language its parsers
from launcher.language.compat import table
from launcher.language.compat.names import PublicModule, is_public, submodules
from launcher.language.session import Session, open_sessions, replace_environment

TOP_NAMES = ("launch", "launch_ros", "launch_testing", "launch_xml", "launch_yaml")
_FOLDER = os.path.dirname(__file__)


class _Finder:
    """Finds and makes the modules of the table."""

    @staticmethod
    def find_spec(
        fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname.partition(".")[0] not in TOP_NAMES or not is_public(fullname):
            return None
        spec = ModuleSpec(fullname, _Finder, origin=table.__file__)  # type: ignore[arg-type]
        if submodules(fullname):
            folder = f"{_FOLDER}/{fullname}"  # not on the disk: whoever lists it asks the table
            spec.submodule_search_locations = [folder]
            sys.path_importer_cache[folder] = _Listing(fullname)
        return spec

    @staticmethod
    def create_module(spec: ModuleSpec) -> ModuleType:
        return PublicModule(spec.name)

    @staticmethod
    def exec_module(module: PublicModule) -> None:
        module.__file__ = table.__file__
        module.provide()
        if module.__name__ == "launch_testing":
            from pkgutil import extend_path

            # What is not in the table is looked up in an installed one.
            module.__path__ = extend_path(module.__path__, module.__name__)


class _Listing:
    """The entry of a public package in `__path__`, for `pkgutil.iter_modules`."""

    def __init__(self, package: str) -> None:
        self._package = package

    def iter_modules(self, prefix: str = "") -> Iterator[tuple[str, bool]]:
        for name in sorted(submodules(self._package)):
            yield prefix + name, bool(submodules(f"{self._package}.{name}"))

    def find_spec(self, fullname: str, target: ModuleType | None = None) -> None:
        """None: the meta-path finder comes first."""


@contextmanager
def vocabulary(words: Sequence[str] | None = None) -> Iterator[Session]:
    """Let `import launch` mean our language; on exit everything is as it was before.

    May be nested; late imports in functions of a launch file need it to be open still. The
    session is for the driver: it may set the folder of the log files. Changes that launch files
    make to `os.environ` are undone on exit. `words` are the target and the arguments of the
    command line: `sys.argv` is set to what `ros2 launch` would have put there.
    """
    argv = sys.argv
    if words is not None:
        sys.argv = ["ros2", "launch", *words]
    session = Session()
    open_sessions.append(session)
    saved = _take_modules()
    finder = _Finder()
    sys.meta_path.insert(0, finder)
    try:
        yield session
    finally:
        replace_environment(session.environment)
        open_sessions.remove(session)
        sys.argv = argv
        sys.meta_path.remove(finder)
        _take_modules()
        sys.modules.update(saved)


def _take_modules() -> dict[str, ModuleType]:
    names = [name for name in sys.modules if name.partition(".")[0] in TOP_NAMES]
    return {name: sys.modules.pop(name) for name in names}
