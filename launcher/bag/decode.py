"""Messages as values, by the definitions that bags have: neither ROS nor its types are needed."""

from __future__ import annotations

import contextlib
import io
import math
import re
from collections.abc import Callable, Iterator
from typing import Any

from launcher.bag.bag_model import CDR, ROS2_MSG, BagError, Definition, Topic, one_line
from launcher.base import strict_json

Decoder = Callable[[bytes], Any]
_STEP = re.compile(r"\[-?\d+\]|[^.\[]+|\[.*")  # of a path: `[2]` or a name
_SEPARATOR = "=" * 80
_PRINTED = re.compile("Error processing '(.*)' of '")
# The library takes `char` for signed, and both times for unsigned if their definitions are missing.
_CHAR = re.compile(r"^(\s*)char\b", re.MULTILINE)
_NAME = "DecodedByLauncher"  # since the library refuses names such as AddTwoInts_Event
# It refuses most names of types with an underscore, too; those of actions have two.
_TYPE = re.compile(r"^(\s*(?:MSG:\s+)?(?:\w+/)*)([A-Z]\w*_\w+)", re.MULTILINE)
_UNDERSCORE = "X5F"
# Their definitions are empty texts, which files do not distinguish from none.
_EMPTY = frozenset(
    {"std_msgs/msg/Empty", "std_srvs/srv/Empty_Request", "std_srvs/srv/Empty_Response"}
)
_DURATION = "builtin_interfaces/Duration"
_DURATION_TEXT = f"\n{_SEPARATOR}\nMSG: {_DURATION}\nint32 sec\nuint32 nanosec\n"


def decoder(topic: Topic) -> Decoder:
    """Turns the bytes of a message into an object with its fields as attributes.

    BagError if the bag says too little about the type; then, or if a message is damaged, also when
    the decoder is called.
    """
    if topic.serialization != CDR:
        raise BagError(f"{topic.name}: messages in '{topic.serialization}' cannot be decoded")
    definition = Definition(text="") if topic.type in _EMPTY else topic.definition
    if definition is None:
        raise BagError(
            f"{topic.name}: the bag has no definition of {topic.type or 'its type'}",
            hint="with the type installed, bag convert writes a bag that has it",
        )
    if definition.encoding != ROS2_MSG:
        raise BagError(
            f"{topic.name}: {topic.type} is defined in '{definition.encoding}', "
            "only .msg definitions can be decoded"
        )
    return _guarded(topic, _compiled(topic, definition.text))


def _compiled(topic: Topic, text: str) -> Decoder:
    from launcher.bag.cdr import compiled

    if f"MSG: {_DURATION}\n" not in text:
        text += _DURATION_TEXT
    name = f"{topic.type.partition('/')[0]}/msg/{_NAME}"
    printed = io.StringIO()  # the parser prints the line that it cannot read
    try:
        with contextlib.redirect_stderr(printed):
            text = _without_underscores(_CHAR.sub(r"\1uint8", text))
            return compiled(name, text, also=_without_underscores(topic.type))
    except Exception as error:  # the parser raises errors of many classes
        line = _PRINTED.search(printed.getvalue())
        reason = _reason(error) + (f" (line {line[1][:100]!r})" if line else "")
        raise BagError(
            f"{topic.name}: the definition of {topic.type} cannot be read: {reason}"
        ) from None


def _without_underscores(text: str) -> str:
    """With names of types that the library takes."""
    return _TYPE.sub(lambda found: found[1] + found[2].replace("_", _UNDERSCORE), text)


def _reason(error: Exception) -> str:
    return one_line(error)[:300].replace(_UNDERSCORE, "_")


def _guarded(topic: Topic, decode: Decoder) -> Decoder:
    def guarded(data: bytes) -> Any:
        try:
            return decode(data)
        except NotImplementedError as error:
            raise BagError(
                f"{topic.name}: {topic.type} has a field of type {error}, which cannot be decoded"
            ) from None
        except Exception as error:  # names of fields that are none of Python, too
            raise BagError(
                f"{topic.name}: a message is not a {topic.type}: {_reason(error)}"
            ) from None

    return guarded


def fields_of(message: object) -> tuple[str, ...]:
    """The names of the fields of a decoded message; none for other values."""
    return tuple(getattr(type(message), "__slots__", ())) if is_message(message) else ()


def is_message(value: object) -> bool:
    return hasattr(type(value), "_full_text")


def is_list(value: object) -> bool:
    return isinstance(value, list | bytes | bytearray | memoryview)


def plain(value: Any) -> Any:
    """The value as JSON can have it; `nan` and `inf` become strings."""
    if is_message(value):
        return {name: plain(getattr(value, name)) for name in fields_of(value)}
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, list):
        return [plain(item) for item in value]
    return list(value) if is_list(value) else value


def cell(value: object) -> str:
    """The value as a field of a CSV file; of arrays and messages, JSON."""
    if isinstance(value, str):
        return value
    if isinstance(value, float):
        return repr(value)
    return strict_json.dumps(plain(value), ensure_ascii=False)


def field_of(message: Any, path: str) -> Any:
    """The value at `a.b[2].c`, as with `topic echo --field`; BagError if there is none."""
    value = message
    for step in _STEP.findall(path):
        try:
            value = value[int(step[1:-1])] if step.startswith("[") else _attribute(value, step)
        except (AttributeError, IndexError, TypeError, ValueError) as error:
            reason = one_line(error)[:300]
            raise BagError(f"Invalid field '{path}': {reason}", hint=_hint(value)) from None
    return value


def _attribute(value: object, name: str) -> Any:
    if name not in fields_of(value):
        raise AttributeError(f"there is no '{name}'")
    return getattr(value, name)


def _hint(value: Any) -> str | None:
    if is_message(value):
        return f"fields: {', '.join(fields_of(value)) or 'none'}"
    return f"it has {len(value)} values: [0] is the first" if is_list(value) else None


def leaves(message: object, prefix: str = "") -> Iterator[str]:
    """The paths of all fields that are not messages themselves; an array is one of them."""
    for name in fields_of(message):
        value = getattr(message, name)
        if is_message(value):
            yield from leaves(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}"
