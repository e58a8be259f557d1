"""Type inference: what an attribute is read as.

The rules for values are those of `launch.utilities.type_utils`; here is only what they do not
know, the entity.
"""

from __future__ import annotations

from typing import Any, List, get_args, get_origin  # noqa: UP035 - List[...] is the API

from launcher.frontends.entity import Entity
from launcher.frontends.entity_errors import UnexpectedContentError, did_you_mean
from launcher.language.type_utils import get_typed_value

MAX_TYPED = 100_000  # characters; what is longer is a text (a robot description), no value

# How `type="..."` of a parameter is written.
TYPE_IDENTIFIERS: dict[str, Any] = {
    "bool": bool,
    "float": float,
    "int": int,
    "str": str,
    "list_of_bool": List[bool],  # noqa: UP006
    "list_of_float": List[float],  # noqa: UP006
    "list_of_int": List[int],  # noqa: UP006
    "list_of_str": List[str],  # noqa: UP006
}


def get_data_type_from_identifier(identifier: str) -> Any:
    """The type of that name; ValueError if there is none."""
    if identifier in TYPE_IDENTIFIERS:
        return TYPE_IDENTIFIERS[identifier]
    hint = did_you_mean(str(identifier), TYPE_IDENTIFIERS)
    known = ", ".join(TYPE_IDENTIFIERS)
    raise UnexpectedContentError(f"there is no type '{identifier}' ({known})", hint=hint)


def is_entity_list(data_type: Any) -> bool:
    """Whether nested entities are asked for: `List[Entity]`, of any class of entities."""
    if get_origin(data_type) is not list:
        return False
    (member,) = get_args(data_type)
    return isinstance(member, type) and issubclass(member, Entity)


def coerce_text(text: str | list[str], data_type: Any, *, can_be_str: bool) -> Any:
    """The value of the text of an XML attribute, or of its pieces.

    ValueError if it is no such value, TypeError if pieces are given for a scalar.
    """
    if len(text) > MAX_TYPED and isinstance(text, str) and can_be_str:
        return text
    return get_typed_value(text, data_type, can_be_str)
