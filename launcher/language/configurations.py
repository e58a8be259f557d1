"""The launch configurations of a scope; they record which names are read."""

from __future__ import annotations

from collections.abc import Callable, ItemsView, Iterator, KeysView, ValuesView

from launcher.language.diagnostics.origin import FileLine, caller_origin

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    _Table = dict[str, Any]
else:
    _Table = dict

_ABSENT = object()
ALL_NAMES = "*"  # recorded when a launch file reads all of them
# ROS 2 reads these for every launch file.
ROS_NAMES = (
    "emulate_tty",
    "launch-prefix",
    "launch-prefix-filter",
    "sigkill_timeout",
    "sigterm_timeout",
)


class Configurations(_Table):
    """A dictionary that records where each value was set.

    `read` is called with each name that is read, which reveals the arguments of a launch file
    that are not declared; `written` with each name, value and origin that is set.
    """

    def __init__(
        self, read: Callable[[str], None], written: Callable[[str, Any, FileLine | None], None]
    ) -> None:
        super().__init__()
        self._read = read
        self._written = written
        self._origins: dict[str, FileLine | None] = {}
        self._defaults: set[str] = set()

    def snapshot(self) -> Configurations:
        """A copy for the stack of scopes; not recorded as a read."""
        copy = Configurations(self._read, self._written)
        dict.update(copy, super().items())
        copy._origins = dict(self._origins)
        copy._defaults = set(self._defaults)
        return copy

    def assign(self, name: str, value: object, origin: FileLine | None) -> None:
        """Set a value, and where it comes from (None: the command line)."""
        super().__setitem__(name, value)
        self._origins[name] = origin
        self._defaults.discard(name)
        self._written(name, value, origin)

    def assign_default(self, name: str, value: object, origin: FileLine | None) -> None:
        """Set the default of a launch argument."""
        self.assign(name, value, origin)
        self._defaults.add(name)

    def is_default(self, name: str) -> bool:
        """Whether the value is the default of a launch argument."""
        return name in self._defaults

    def origin_of(self, name: str) -> FileLine | None:
        """Where the value was set; None for the command line."""
        return self._origins.get(name)

    def differing(self, other: Configurations) -> list[str]:
        """Names whose value is not the same in the other one."""
        mine, others = dict(super().items()), dict(dict.items(other))
        return sorted(name for name in mine if others.get(name, _ABSENT) != mine[name])

    def peek(self, name: str) -> Any:
        """The value or None; not recorded as a read."""
        return super().get(name)

    def __setitem__(self, name: str, value: object) -> None:
        self.assign(name, value, caller_origin())

    def __getitem__(self, name: str) -> Any:
        self._read(name)
        if name not in self:
            raise KeyError(name)
        return super().__getitem__(name)

    def update(self, *others: object, **values: object) -> None:
        for name, value in dict(*others, **values).items():
            self[name] = value

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies are plain dictionaries."""
        return (dict, (self.copy(),))

    def __contains__(self, name: object) -> bool:
        self._read(str(name))
        return super().__contains__(name)

    def get(self, name: str, default: object = None) -> Any:
        """The value, else the default."""
        self._read(name)
        return super().get(name, default)

    def setdefault(self, name: str, default: object = None) -> Any:
        """The value, set to the default if there is none."""
        self._read(name)
        return super().setdefault(name, default)

    def __iter__(self) -> Iterator[str]:
        self._read(ALL_NAMES)
        return super().__iter__()

    def items(self) -> ItemsView[str, Any]:  # type: ignore[override]
        self._read(ALL_NAMES)
        return super().items()

    def keys(self) -> KeysView[str]:  # type: ignore[override]
        self._read(ALL_NAMES)
        return super().keys()

    def values(self) -> ValuesView[Any]:  # type: ignore[override]
        self._read(ALL_NAMES)
        return super().values()

    def copy(self) -> dict[str, Any]:
        self._read(ALL_NAMES)
        return dict(super().items())
