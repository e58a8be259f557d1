"""Configurations: the launch configurations of a scope, which notice what is read."""

from __future__ import annotations

from collections.abc import Callable, ItemsView, Iterator, KeysView, ValuesView
from typing import Any

ALL_NAMES = "*"  # what is noted when a launch file looks at all of them


class Configurations(dict[str, Any]):
    """A dictionary; `read` is called with each name that is asked for.

    So the launcher knows which arguments a launch file understands, also those that nothing
    declares.
    """

    def __init__(self, read: Callable[[str], None], values: dict[str, Any] | None = None) -> None:
        super().__init__(values or {})
        self._read = read

    def snapshot(self) -> Configurations:
        """A copy for the stack of scopes; nothing is noted."""
        return Configurations(self._read, dict(super().items()))

    def __getitem__(self, name: str) -> Any:
        self._read(name)
        return super().__getitem__(name)

    def __contains__(self, name: object) -> bool:
        self._read(str(name))
        return super().__contains__(name)

    def get(self, name: str, default: Any = None) -> Any:
        """The value, else the default."""
        self._read(name)
        return super().get(name, default)

    def setdefault(self, name: str, default: Any = None) -> Any:
        """The value, set to the default if there is none."""
        self._read(name)
        return super().setdefault(name, default)

    def __iter__(self) -> Iterator[str]:
        self._read(ALL_NAMES)
        return super().__iter__()

    def items(self) -> ItemsView[str, Any]:  # type: ignore[override]
        """All pairs."""
        self._read(ALL_NAMES)
        return super().items()

    def keys(self) -> KeysView[str]:  # type: ignore[override]
        """All names."""
        self._read(ALL_NAMES)
        return super().keys()

    def values(self) -> ValuesView[Any]:  # type: ignore[override]
        """All values."""
        self._read(ALL_NAMES)
        return super().values()

    def copy(self) -> dict[str, Any]:
        """A plain dictionary."""
        self._read(ALL_NAMES)
        return dict(super().items())
