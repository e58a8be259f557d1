"""Registry of the names that XML and YAML launch files know, and the parsers behind them.

The front ends import the language, never the reverse; `Action.parse` and its like reach the
parse functions of `launcher.frontends` through `parse_with`, which loads them when first needed.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from types import FunctionType, MethodType

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, TypeVar

    _T = TypeVar("_T", bound=Callable[..., Any])

_PARSERS_MODULE = "launcher.frontends.parsers"
_GRAMMAR_MODULE = "launcher.frontends.grammar_substitutions"

# Tag or substitution name -> parse function: (entity, parser) or (data,) -> (class, kwargs).
action_parse_methods: dict[str, Callable[..., Any]] = {}
substitution_parse_methods: dict[str, Callable[..., Any]] = {}

# Name of a class of the language -> function (cls, *args, **kwargs) -> (class, kwargs).
class_parsers: dict[str, Callable[..., Any]] = {}


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


def _parse_method(exposed: Any, name: str, kind: str) -> Callable[..., Any]:
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


def parse_with(parser_name: str, cls: type, *args: Any, **kwargs: Any) -> Any:
    """Call the parse function that `launcher.frontends.parsers` registered for a class."""
    if parser_name not in class_parsers:
        importlib.import_module(_PARSERS_MODULE)
    return class_parsers[parser_name](cls, *args, **kwargs)


def parse_base_action(cls: type, entity: Any, parser: Any) -> Any:
    """(class, {'condition': ...}) from the attributes `if` and `unless`."""
    return parse_with("Action", cls, entity, parser)


def parse_substitution(text: str) -> list[Any]:
    """The substitutions of a text with `$(...)` in it."""
    parsed: list[Any] = importlib.import_module(_GRAMMAR_MODULE).parse_substitution(text)
    return parsed
