"""The launch configurations of a scope; they record which names are read."""

from __future__ import annotations

import sys
from collections.abc import Callable, ItemsView, Iterable, Iterator, KeysView, ValuesView

from launcher.language.diagnostics.origin import FileLine, caller_origin

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    _Table = dict[str, Any]
    _Kept = tuple[Any, FileLine | None, bool]
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

    A large launch has thousands of names and of scopes: a scope keeps what its changes replace,
    instead of the copy of all that ROS 2 makes.
    """

    def __init__(
        self, read: Callable[[str], None], written: Callable[[str, Any, FileLine | None], None]
    ) -> None:
        super().__init__()
        self._read = read
        self._written = written
        self._origins: dict[str, FileLine | None] = {}
        self._defaults: set[str] = set()
        # Of the scopes within these configurations, the innermost last: (value or _ABSENT, origin,
        # whether it is a default) by name, or a copy from before if names were removed.
        self._scopes: list[dict[str, _Kept] | Configurations] = []

    def snapshot(self) -> Configurations:
        """A copy outside of all scopes; not recorded as a read."""
        copy = Configurations(self._read, self._written)
        dict.update(copy, super().items())
        copy._origins = dict(self._origins)
        copy._defaults = set(self._defaults)
        return copy

    # ---- scopes

    def begin_scope(self) -> None:
        """What is changed from now on is undone by `end_scope`."""
        self._scopes.append({})

    def end_scope(self) -> Configurations:
        """The configurations from before the scope.

        This object, unless a launch file has kept it: in ROS 2 that has the values of the scope.
        """
        is_kept = sys.getrefcount(self) > _REFERENCES_OF_ONE
        kept = self._scopes.pop()
        if not isinstance(kept, Configurations):
            if not is_kept:
                self._restore(kept)
                return self
            kept = self._before(kept)
        kept._scopes, self._scopes = self._scopes, []
        return kept

    def _before(self, kept: dict[str, _Kept]) -> Configurations:
        copy = self.snapshot()
        copy._restore(kept)
        return copy

    def _restore(self, kept: dict[str, _Kept]) -> None:
        for name, (value, origin, is_default) in kept.items():
            if value is _ABSENT:
                super().__delitem__(name)
                self._origins.pop(name, None)
            else:
                super().__setitem__(name, value)
                self._origins[name] = origin
            if is_default:
                self._defaults.add(name)
            else:
                self._defaults.discard(name)

    def _keep(self, name: str) -> None:
        """A value is about to be set."""
        kept = self._scopes[-1] if self._scopes else None
        if kept is not None and not isinstance(kept, Configurations) and name not in kept:
            value = super().get(name, _ABSENT)
            kept[name] = (value, self._origins.get(name), name in self._defaults)

    def _keep_all(self) -> None:
        """Names are about to be removed, which would change their order."""
        kept = self._scopes[-1] if self._scopes else None
        if kept is not None and not isinstance(kept, Configurations):
            self._scopes[-1] = self._before(kept)

    def outer(self, name: str) -> Any:
        """The value outside of the innermost scope, None without one; not recorded as a read."""
        value = self._value_at(len(self._scopes) - 1, name) if self._scopes else _ABSENT
        return None if value is _ABSENT else value

    def _value_at(self, depth: int, name: str) -> Any:
        """The value in so many scopes, or _ABSENT."""
        for kept in self._scopes[depth:]:
            if isinstance(kept, Configurations):
                return dict.get(kept, name, _ABSENT)
            if name in kept:
                return kept[name][0]
        return super().get(name, _ABSENT)

    # ---- the dictionary

    def assign(self, name: str, value: object, origin: FileLine | None) -> None:
        """Set a value, and where it comes from (None: the command line)."""
        self._keep(name)
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
        """Names whose value is not the same in the other ones, outside of all their scopes."""
        names: Iterable[str] = super().keys()
        if other is self and not any(isinstance(kept, Configurations) for kept in self._scopes):
            names = {
                name for kept in self._scopes for name in kept if dict.__contains__(self, name)
            }
        return sorted(name for name in names if other._value_at(0, name) != self.peek(name))

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
        self._keep(name)
        return super().setdefault(name, default)

    def pop(self, name: str, *default: object) -> Any:
        """Remove a name; its value, else the default, KeyError without one."""
        if super().__contains__(name):
            self._keep_all()
        return super().pop(name, *default)

    def popitem(self) -> tuple[str, Any]:
        """Remove the name that was set first last; it and its value."""
        self._keep_all()
        return super().popitem()

    def clear(self) -> None:
        """Remove all names."""
        self._keep_all()
        super().clear()

    def __delitem__(self, name: str) -> None:
        self._keep_all()
        super().__delitem__(name)

    def __ior__(self, others: Any) -> Any:  # type: ignore[misc]  # unlike `|`
        self.update(others)
        return self

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

    def _references(self) -> int:
        return sys.getrefcount(self)


def _references_of_one() -> int:
    """What `sys.getrefcount` gives in a method if only one attribute has the object."""

    class Owner:
        configurations = Configurations(str, lambda *words: None)  # type: ignore[arg-type]

    return Owner.configurations._references()


_REFERENCES_OF_ONE = _references_of_one()
