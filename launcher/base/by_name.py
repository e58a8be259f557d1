"""Objects by their names, for tables whose rows are imported only when they are used."""

from __future__ import annotations

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any


def load(path: str) -> Any:
    """The object that `module:name` stands for; its module is imported now."""
    module, _, name = path.partition(":")
    __import__(module)
    return getattr(sys.modules[module], name)


def lazy(path: str, **more: object) -> Callable[[Any], Any]:
    """A function of one argument that calls the one that `module:name` stands for."""
    return lambda value: load(path)(value, **more)
