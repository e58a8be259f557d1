"""What ROS 2's interface has in each class: a module path, and attributes that are only read."""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter
from types import FunctionType

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, TypeVar

    _T = TypeVar("_T", bound=type)


def public(module: str) -> Callable[[_T], _T]:
    """Give a class the `__module__` that it has in ROS 2.

    Users see these paths in messages (`<launch.actions.log_info.LogInfo object at ...>`), and
    launch files print them. So is the name of the class in messages about a call
    (`LogInfo.__init__() missing ...`), also where the constructor is that of a base of ours.
    """

    def rename(cls: _T) -> _T:
        cls.__module__ = module
        owner = next(one for one in cls.__mro__ if "__init__" in vars(one))
        if owner.__module__.startswith("launcher."):
            constructor = _named(vars(owner)["__init__"], f"{cls.__qualname__}.__init__")
            cls.__init__ = constructor  # type: ignore[misc]  # nobody has a subclass of it yet
        return cls

    return rename


def _named(function: FunctionType, name: str) -> FunctionType:
    """A copy, since all classes that inherit it share the name."""
    code, scope = function.__code__, function.__globals__
    copy = FunctionType(code, scope, function.__name__, function.__defaults__, function.__closure__)
    copy.__kwdefaults__ = function.__kwdefaults__
    copy.__annotations__ = function.__annotations__
    copy.__doc__ = function.__doc__
    copy.__qualname__ = name
    return copy


def read_only(doc: str | None = None, *, of: str | None = None) -> Any:
    """A property with this docstring: what the constructor has put into an attribute of `self`.

    The attribute is the private one of the same name (`__name` for `name`), or `of`.
    """
    return _ReadOnly(doc, of)


class _ReadOnly(property):
    def __init__(self, doc: str | None, of: str | None) -> None:
        super().__init__()
        self.__doc__ = doc
        self._of = of

    def __set_name__(self, owner: type, name: str) -> None:
        attribute = self._of or f"__{name}"
        if attribute.startswith("__"):  # as the compiler does it in the body of the class
            attribute = f"_{owner.__name__.lstrip('_')}{attribute}"
        doc = self.__doc__
        super().__init__(attrgetter(attribute))
        self.__doc__ = doc  # the getter's own until here
        super().__set_name__(owner, name)  # type: ignore[misc]  # not in the stubs
