"""Frozen value classes that are faster to define than dataclasses.

A frozen dataclass takes 0.5 ms to define, since its methods are compiled, and importing
`dataclasses` takes 8 ms: together a third of the time to the first process. Type checkers treat
these classes as dataclasses.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, ClassVar, TypeVar

    from typing_extensions import dataclass_transform

    R = TypeVar("R", bound="Record")
else:

    def dataclass_transform(**options: object) -> Any:
        return lambda cls: cls


_Function = type(lambda: None)


@dataclass_transform(frozen_default=True, eq_default=True)
class Record:
    """Base of frozen values: fields are the annotations, defaults the class attributes.

    Fields may be given by position or by name. Equality, hash and repr are by value. A default
    must be immutable, since it is shared. Raises TypeError for a field that is missing, unknown
    or given twice.
    """

    _fields: ClassVar[tuple[str, ...]] = ()
    _required: ClassVar[frozenset[str]] = frozenset()
    _known: ClassVar[frozenset[str]] = frozenset()

    def __init_subclass__(cls) -> None:
        fields = [name for name in cls.__annotations__ if name[0] != "_"]
        cls._fields = (*cls._fields, *fields)
        cls._known = frozenset(cls._fields)
        cls._required = frozenset(name for name in cls._fields if not hasattr(cls, name))
        type.__setattr__(cls, "__match_args__", cls._fields)  # for `match` by position
        for name in fields:
            default = cls.__dict__.get(name)
            if isinstance(default, _Function):  # else it would be a method
                type.__setattr__(cls, name, staticmethod(default))

    def __init__(self, *values: object, **named: object) -> None:
        fields = self._fields
        if not named and len(values) == len(fields):  # most are made in one of these two ways
            self.__dict__.update(zip(fields, values))  # noqa: B905
            return
        if not values and self._required <= named.keys() <= self._known:
            self.__dict__.update(named)
            return
        if values:
            given = dict(zip(fields, values))  # noqa: B905  (too many raise below)
            if len(values) > len(fields) or given.keys() & named.keys():
                raise TypeError(f"{type(self).__name__} takes {', '.join(fields)}, each once")
            named.update(given)
        if not self._required <= named.keys():
            missing = next(name for name in fields if name in self._required - named.keys())
            raise TypeError(f"{type(self).__name__} needs '{missing}'")
        for name in named:
            if name not in fields:
                raise TypeError(f"{type(self).__name__} has no '{name}'")
        self.__dict__.update(named)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} is frozen")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{type(self).__name__} is frozen")

    def _values(self) -> tuple[Any, ...]:
        return tuple(getattr(self, name) for name in self._fields)

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self._values() == other._values()

    def __hash__(self) -> int:
        return hash((type(self), self._values()))

    def __repr__(self) -> str:
        inside = ", ".join(f"{name}={getattr(self, name)!r}" for name in self._fields)
        return f"{type(self).__name__}({inside})"


def replace(record: R, **changes: object) -> R:
    """The same record with some fields changed."""
    return type(record)(**{**dict(zip(record._fields, record._values())), **changes})  # noqa: B905


def as_dict(record: Record) -> dict[str, Any]:
    """The fields by name; values that are records stay so."""
    return {name: getattr(record, name) for name in record._fields}
