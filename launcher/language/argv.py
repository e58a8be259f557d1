"""`sys.argv` while a launch file is evaluated."""

from __future__ import annotations

from collections.abc import Callable, Iterable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    _Words = list[str]
else:
    _Words = list

_HEAD = ("ros2", "launch")
_FIRST = len(_HEAD) + 1  # the first word behind the launch file


class Argv(_Words):
    """The words of `ros2 launch`, which calls `read` when one behind the launch file is looked at.

    Copies are plain lists.
    """

    def __init__(self, words: Iterable[str], read: Callable[[], None]) -> None:
        super().__init__([*_HEAD, *words])
        self._read = read

    def __getitem__(self, index: Any) -> Any:
        places = range(len(self))[index] if isinstance(index, slice) else [index % (len(self) or 1)]
        if any(place >= _FIRST for place in places):
            self._read()
        return super().__getitem__(index)

    def __radd__(self, other: list[str]) -> list[str]:
        return other + list(self)

    def __reduce__(self) -> tuple[Any, ...]:
        return (list, (list(self),))


def _reading(name: str) -> Any:
    method = getattr(list, name)

    def read(self: Argv, *words: object, **more: object) -> Any:
        self._read()
        return method(self, *words, **more)

    return read


for _name in (
    *("__add__", "__contains__", "__eq__", "__iter__", "__mul__", "__ne__", "__repr__"),
    *("__reversed__", "copy", "count", "index", "pop", "remove"),
):
    setattr(Argv, _name, _reading(_name))
