"""YAML text: what a person has typed, as plain values, with one kind of error."""

from __future__ import annotations

from typing import Any

import yaml

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
# Nothing that ROS carries is as deep, and what is far deeper would overflow the parser's C stack.
_DEPTH = 100
# What PyYAML lets through of `!!bool x`, `!!timestamp x` and their like.
_STUMBLES = (LookupError, AttributeError, TypeError, OverflowError)


def value_of(text: str) -> Any:
    """The value that a text holds, None if it is empty; yaml.YAMLError and no other."""
    try:
        if len(text) > _DEPTH:
            _refuse_depth(text)
        return yaml.load(text, Loader=_LOADER)
    except ValueError as error:  # a date that is none, `!!int x`
        raise yaml.YAMLError(str(error)) from error
    except _STUMBLES as error:
        raise yaml.YAMLError("a value is not what its tag (!!) says") from error


def _refuse_depth(text: str) -> None:
    depth = 0
    for event in yaml.parse(text, Loader=_LOADER):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
            if depth > _DEPTH:
                mark: Any = event.start_mark
                raise yaml.MarkedYAMLError(problem=f"more than {_DEPTH} levels", problem_mark=mark)
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1


def shown(value: Any, most: int = 60) -> str:
    """Like repr, at most so many characters; Python refuses to write numbers of a mile's length."""
    try:
        text = repr(value)
    except ValueError:
        return "a number of thousands of digits"
    return text if len(text) <= most else text[: most - 3] + "..."
