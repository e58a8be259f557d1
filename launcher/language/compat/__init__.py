"""The import names `launch` and `launch_ros`, answered by our own vocabulary for a while.

The folders below hold real modules that only re-export. They are found by a meta-path finder
that is active inside of `vocabulary()` and nowhere else, so that a real ROS 2, or the folder
`launch/` of a workspace, is what it always was for everybody else.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType

from launcher.language.session import Session, open_sessions, replace_environment

_FOLDER = os.path.dirname(__file__)
TOP_NAMES = ("launch", "launch_ros", "launch_testing", "launch_xml", "launch_yaml")


class _Finder:
    """Answers the top names; their submodules follow through `__path__`."""

    @staticmethod
    def find_spec(
        fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname not in TOP_NAMES:
            return None
        return PathFinder.find_spec(fullname, [_FOLDER])


@contextmanager
def vocabulary(words: Sequence[str] | None = None) -> Iterator[Session]:
    """Let `import launch` mean our vocabulary; on exit everything is as it was before.

    May be nested; late imports in functions of a launch file need it to be open still. The
    session is for the driver: it may set the folder of the log files. What launch files do to
    `os.environ` is undone in the end. `words` are the target
    and the arguments of the command line; some launch files look for them in `sys.argv`, and
    find there what `ros2 launch` would have put.
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
