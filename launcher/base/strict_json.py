"""JSON, the only place where it is written and read.

Names and texts of processes may have bytes that are no characters, which Python keeps as surrogates
and UTF-8 does not have; `dumps` replaces them. What others send may be no JSON in more ways than a
wrong comma; `loads` raises ValueError for all of them. `packed` and `unpacked` are for messages
between processes of the launcher, which get each text and number back as it was.
"""

from __future__ import annotations

import json
import math
import re

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

MAX_DEPTH = 200  # of objects and lists in each other; other functions recurse over them, too

# Of escapes only those of surrogates that are no pair; a backslash may itself be escaped.
_PART = re.compile(r"\\\\|\\ud[89ab]..\\ud[c-f]..|(\\ud[89a-f]..|[\ud800-\udfff])")
_MAYBE_TOO_LARGE = re.compile(r"\d{300}|[eE]\+?\d{3}")


def dumps(
    value: Any,
    *,
    default: Callable[[Any], Any] | None = None,
    not_finite: Callable[[float], Any] = lambda number: None,
    **style: Any,
) -> str:
    """JSON for people and other programs; `default` and `style` as for `json.dumps`.

    What is no character becomes U+FFFD, and numbers that JSON does not have what `not_finite` says.
    """

    def finite(one: object) -> Any:
        if isinstance(one, float):
            return one if math.isfinite(one) else not_finite(one)
        if isinstance(one, dict):
            return {key: finite(each) for key, each in one.items()}
        if isinstance(one, (list, tuple)):
            return [finite(each) for each in one]
        is_plain = one is None or isinstance(one, (str, int))
        return one if is_plain or default is None else finite(default(one))

    try:
        text = json.dumps(value, allow_nan=False, default=default, **style)
    except ValueError:
        text = json.dumps(finite(value), **style)
    return _replaced(text)


def loads(text: str | bytes) -> Any:
    """What others have sent or written; ValueError for everything that cannot be used.

    That is what is not JSON, what is deeper than MAX_DEPTH, and numbers that no float can be.
    """
    text = text if isinstance(text, str) else text.decode("utf-8-sig")
    hooks: dict[str, Any] = {"parse_constant": _no_constant}
    if _MAYBE_TOO_LARGE.search(text):
        hooks |= {"parse_float": _float, "parse_int": _int}
    return unpacked(text, **hooks)


def packed(value: Any, **style: Any) -> str:
    """A message to another process of the launcher, in ASCII."""
    return json.dumps(value, **style)


def unpacked(text: str | bytes, **style: Any) -> Any:
    """What `packed` has made, or another program in Python, with nan and inf; ValueError."""
    try:
        value = json.loads(text, **style)
    except RecursionError:
        raise ValueError(_TOO_DEEP) from None
    text = text if isinstance(text, str) else text.decode("latin-1")
    if text.count("[") + text.count("{") > MAX_DEPTH and _is_deep(value):
        raise ValueError(_TOO_DEEP)
    return value


_TOO_DEEP = f"objects and lists are more than {MAX_DEPTH} deep"


def _replaced(text: str) -> str:
    if "\\ud" in text or not (text.isascii() or _is_unicode(text)):
        return _PART.sub(_replacement, text)
    return text


def _replacement(part: re.Match[str]) -> str:
    if part[1] is None:
        return part[0]
    return "\ufffd" if len(part[1]) == 1 else r"\ufffd"


def _is_unicode(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _is_deep(value: object) -> bool:
    level = [value]
    for _ in range(MAX_DEPTH):
        level = [child for one in level for child in _children(one)]
        if not level:
            return False
    return True


def _children(value: object) -> Any:
    if isinstance(value, dict):
        return value.values()
    return value if isinstance(value, list) else ()


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is not JSON")


def _float(digits: str) -> float:
    value = float(digits)
    if not math.isfinite(value):
        raise ValueError(f"{digits[:20]} is too large")
    return value


def _int(digits: str) -> int:
    try:
        value = int(digits)
        float(value)
    except (OverflowError, ValueError):  # of Python for more than 4300 digits
        raise ValueError(f"{digits[:20]}... is too large") from None
    return value
