"""Registry of tags and substitutions, and of the parsers for XML and YAML launch files.

The front ends import the language, never the reverse: `launcher.language.frontends` provides its
functions here when it is imported.
"""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType, MethodType

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, TypeVar

    _C = TypeVar("_C", bound=type)
    _T = TypeVar("_T", bound=Callable[..., Any])

# Tag or substitution name -> parse function: (entity, parser) or (data,) -> (class, kwargs).
action_parse_methods: dict[str, Callable[..., Any]] = {}
substitution_parse_methods: dict[str, Callable[..., Any]] = {}

_provided: dict[str, Callable[..., Any]] = {}


def provide(**functions: Callable[..., Any]) -> None:
    """Set what `parse_with`, `parse_substitution` and `parser_class` call."""
    _provided.update(functions)


def parse_with(key: str, *args: Any, **kwargs: Any) -> Any:
    """Call the parse function that the front ends have for a class or another key."""
    return _provided["parse_with"](key, *args, **kwargs)


def parse_substitution(text: str) -> list[Any]:
    """The substitutions of a text with `$(...)` in it."""
    substitutions: list[Any] = _provided["parse_substitution"](text)
    return substitutions


def parser_class(extension: str) -> Any:
    """The class that reads `xml` or `yaml` files; for "" one that tries both."""
    return _provided["parser_class"](extension)


def parsed(cls: _C) -> _C:
    """Class decorator: add the class method `parse` for XML and YAML entities.

    It returns (class, keyword arguments), as the front ends' parse function of this name does.
    """
    name = cls.__name__

    def parse(cls: type, *args: Any, **kwargs: Any) -> Any:
        """(class, keyword arguments) of an XML or YAML entity."""
        return parse_with(name, cls, *args, **kwargs)

    cls.parse = classmethod(parse)  # type: ignore[attr-defined]
    return cls


def expose_action(name: str) -> Callable[[_T], _T]:
    """Class decorator: make an action with a `parse` class method known as a tag."""
    return _exposer(name, action_parse_methods, "action")


def expose_substitution(name: str) -> Callable[[_T], _T]:
    """Class decorator: make a substitution with a `parse` class method known as `$(name ...)`."""
    return _exposer(name, substitution_parse_methods, "substitution")


def _exposer(name: str, table: dict[str, Callable[..., Any]], kind: str) -> Callable[[_T], _T]:
    def expose(exposed: _T) -> _T:
        parse = _parse_method(exposed, name, kind)
        known = table.get(name)
        if known is not None and _identity(known) != _identity(parse):
            raise RuntimeError(f"Two {kind} parsing methods exposed with the same name: [{name}].")
        table[name] = parse
        return exposed

    return expose


def _parse_method(exposed: object, name: str, kind: str) -> Callable[..., Any]:
    """The class method `parse` of a class, or the function itself."""
    if isinstance(exposed, type):
        parse = getattr(exposed, "parse", None)
        if parse is None or not isinstance(parse, MethodType):
            raise RuntimeError(
                "Did not find a class method called 'parse' in the class being decorated."
            )
        return parse
    if isinstance(exposed, FunctionType):
        return exposed
    raise RuntimeError(
        f"Exposed {kind} parser for {name} is not a callable or a class containing a parse method"
    )


def _identity(parse: Callable[..., Any]) -> tuple[str, str]:
    # Not the object: a module that is loaded anew, in a later run, exposes the same names again.
    owner = getattr(parse, "__self__", parse)
    return owner.__module__, owner.__qualname__
