"""Describes types so that a form for their values can be made."""

from __future__ import annotations

from typing import Any

from rosidl_parser import definition

from launcher.base.ros_errors import VerbError
from launcher.ros.messages.classes import class_of
from launcher.ros.messages.from_yaml import LIMITS
from launcher.ros.messages.interfaces import KINDS, load, resolve
from launcher.ros.messages.to_yaml import is_list, kind_name

# names of IDL -> those of .msg files, which are the same for all others
_NAMES = {"boolean": "bool", "octet": "byte", "float": "float32", "double": "float64"}
_PARTS = {"srv": ("request", "response"), "action": ("goal", "result", "feedback")}


def form(type_name: str) -> dict[str, Any]:
    """The fields of a message, service or action; VerbError if there is no such type."""
    full, cls, kind = _load(type_name)
    head = {"type": full, "kind": kind}
    if kind == "msg":
        return {**head, "fields": fields_of(cls)}
    return {**head, **{part: fields_of(getattr(cls, part.title())) for part in _PARTS[kind]}}


def _load(type_name: str) -> tuple[str, Any, str]:
    """Full name, class and kind. Messages of which services are made count as messages."""
    package, _, rest = type_name.partition("/")
    kind, _, name = rest.partition("/")
    unknown = f"Unknown interface '{type_name}'"
    if kind in KINDS and "_" in name and package.isidentifier():
        return type_name, load(type_name, "msg", unknown), "msg"
    try:
        full = resolve(type_name)
    except VerbError as error:
        raise VerbError(error.message, hint=error.hint or "installed: interface list") from None
    kind = full.split("/")[1]
    return full, load(full, kind, unknown), kind


def fields_of(cls: Any) -> list[dict[str, Any]]:
    """The fields of a generated class in their order."""
    message, constants = cls(), _constants(cls)
    fields = zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES, strict=True)
    return [_field(name, slot, getattr(message, name), constants) for name, slot in fields]


def _field(name: str, slot: object, value: object, constants: dict[str, int]) -> dict[str, Any]:
    kind = getattr(slot, "value_type", slot)  # that of the elements of an array
    nested = None
    if isinstance(kind, definition.NamespacedType):
        nested = fields_of(class_of(*kind.namespaced_name()))
    base = kind_name(kind)
    base = _NAMES.get(base, base)
    return {
        "name": name,
        "type": base,
        "array": _array(slot),
        "string_most": getattr(kind, "maximum_size", None),
        "default": _default(value, nested),
        "constants": {key: held for key, held in constants.items() if _fits(held, base)},
        "fields": nested,
    }


def _array(slot: object) -> dict[str, int | None] | None:
    if not isinstance(slot, definition.AbstractNestedType):
        return None
    size = slot.size if isinstance(slot, definition.Array) else None
    most = slot.maximum_size if isinstance(slot, definition.BoundedSequence) else None
    return {"size": size, "most": most}


def _default(value: Any, nested: list[dict[str, Any]] | None) -> Any:
    """The value of a new message; a byte is a number."""
    if is_list(value):
        items = value.tolist() if hasattr(value, "tolist") else value
        return [_default(item, nested) for item in items]
    if isinstance(value, bytes):
        return value[0]
    if nested is not None:
        return {field["name"]: field["default"] for field in nested}
    return value.item() if hasattr(value, "item") else value


def _constants(cls: object) -> dict[str, int]:
    """The whole numbers among the constants of a message."""
    held = getattr(type(cls), f"_{type(cls).__name__}__constants", {})
    numbers = {key: value[0] if isinstance(value, bytes) else value for key, value in held.items()}
    return {key: value for key, value in numbers.items() if type(value) is int}


def _fits(number: int, base: str) -> bool:
    low, high = LIMITS.get("uint8" if base == "byte" else base, (1, 0))
    return low <= number <= high
