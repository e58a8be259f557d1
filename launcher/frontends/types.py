"""Type inference: what an attribute is read as.

The rules for values are those of `launch.utilities.type_utils`; here is only what they do not
know, the entity.
"""

from __future__ import annotations

from typing import Any, get_args, get_origin

from launcher.frontends.entity import Entity
from launcher.language.type_utils import get_typed_value


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
    return get_typed_value(text, data_type, can_be_str)
