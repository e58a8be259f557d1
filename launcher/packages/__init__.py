"""ROS packages, their executables and colcon workspaces: where they are, without running them.

May import `base` and `posix`. Nothing of it is imported here, since the search for a workspace is
on the way to the first process of every launch, and that for packages takes longer to import.

Doors:

* `finder`: the prefix and share folder of a package, its executables; its docstring has the order
  of search. `source_packages`: packages used from their source folder, by `setup_reader` (a
  separate process: what their setup.py would install) and `overlay` (a prefix of links to that).
  `entry_points`: console scripts that pip has installed. `byte_code`: packages that Python compiles
  at every start.
* `distribution`: which ROS 2 is in use, and the variables that name it. `package_origins`: where
  well-known packages come from: a wheel, sources, an installation of ROS 2.
* `workspace`: the colcon workspace that a user has named, or the one around the working directory.
  `activation`: this process sees the workspace, and is
  executed again where the loader needs `LD_LIBRARY_PATH` from the start. `environment` and
  `hooks`: what its packages set, from colcon's `.dsv` files; no script is run.
* `python_program`: which commands are Python programs of this interpreter; `imports`: what such a
  program imports. Warm starts are prepared by these.
* `program_fault`: why a program cannot be executed. `unknown`: the error and its hints for a
  package that is not found; `unbuilt`: interfaces that are not built; `extras`: how to install an
  extra of this distribution.
"""

from __future__ import annotations

import contextlib

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import Any, TypeVar

    T = TypeVar("T")

_kept: dict[str, Any] = {}  # what was read since the outermost `reading_once` began
_readers = 0


@contextlib.contextmanager
def reading_once() -> Iterator[None]:
    """For what looks at many packages: what is installed and around is read once meanwhile.

    Threads may do so at the same time: what is kept is forgotten when the last one ends.
    """
    global _readers
    _readers += 1
    try:
        yield
    finally:
        _readers -= 1
        if not _readers:
            _kept.clear()


def is_reading_once() -> bool:
    return _readers > 0


def once(key: str, read: Callable[[], T]) -> T:
    """What `read` returns; within `reading_once` what it has returned for the key before."""
    if key in _kept:
        found: T = _kept[key]
        return found
    value = read()
    if is_reading_once():
        _kept[key] = value
    return value
