"""The ROS 2 module path that a public class shows in its repr."""

from __future__ import annotations

from collections.abc import Callable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TypeVar

    _T = TypeVar("_T", bound=type)


def public(module: str) -> Callable[[_T], _T]:
    """Give a class the `__module__` that it has in ROS 2.

    Users see these paths in messages (`<launch.actions.log_info.LogInfo object at ...>`), and
    launch files print them.
    """

    def rename(cls: _T) -> _T:
        cls.__module__ = module
        return cls

    return rename
