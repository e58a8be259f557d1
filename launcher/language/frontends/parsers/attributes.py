"""Helpers of the parse functions: conditions, texts, name-value pairs, nested actions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, List  # noqa: UP035 - List[Entity] is what entities understand

from launcher.language.diagnostics.origin import FileLine
from launcher.language.frontends.entity import Entity
from launcher.language.frontends.errors import StructureError

if TYPE_CHECKING:
    from launcher.language.frontends.parser import Parser

ENTITIES = List[Entity]  # noqa: UP006

Parsed = tuple[type, dict[str, Any]]


def parse_action(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """(class, keyword arguments) with the condition, if given."""
    condition = parse_condition(entity, parser)
    return cls, {} if condition is None else {"condition": condition}


def parse_condition(entity: Entity, parser: Parser) -> Any:
    """An IfCondition, an UnlessCondition or None; RuntimeError if there are both attributes."""
    if_text = entity.get_attr("if", optional=True)
    if_place = entity.place
    unless_text = entity.get_attr("unless", optional=True)
    if if_text is None and unless_text is None:
        return None
    if if_text is not None and unless_text is not None:
        message = "'if' and 'unless' cannot be used together"
        raise StructureError(message, place=if_place, hint="combine them: $(and ...), $(not ...)")
    from launcher.language.conditions import IfCondition, UnlessCondition

    text, kind = (if_text, IfCondition) if unless_text is None else (unless_text, UnlessCondition)
    condition = kind(parser.parse_substitution(text))
    place = parser._place_of(text) if hasattr(parser, "_place_of") else None
    if place is not None:
        condition._origin = FileLine(place.path, place.line)
    return condition


def add_texts(
    arguments: dict[str, Any],
    entity: Entity,
    parser: Parser,
    attributes: Mapping[str, str],
    *,
    optional: bool,
) -> None:
    """Add, for each `keyword: attribute`, the substitutions of the attribute, if it is there."""
    for keyword, attribute in attributes.items():
        text = entity.get_attr(attribute, optional=optional)
        if text is not None:
            arguments[keyword] = parser.parse_substitution(text)


def parse_texts(cls: type, entity: Entity, parser: Parser, attributes: Mapping[str, str]) -> Parsed:
    """Parse an action whose attributes are all required texts: `keyword: attribute`."""
    _, arguments = parse_action(cls, entity, parser)
    add_texts(arguments, entity, parser, attributes, optional=False)
    return cls, arguments


def name_value_pairs(
    entity: Entity, parser: Parser, tag: str, *, names: tuple[str, str] = ("name", "value")
) -> list[tuple[Any, Any]] | None:
    """The (name, value) of each nested `tag`, as substitutions; None if there is none."""
    nested = entity.get_attr(tag, data_type=ENTITIES, optional=True)
    if nested is None:
        return None
    pairs = []
    for one in nested:
        first, second = (parser.parse_substitution(one.get_attr(name)) for name in names)
        one.assert_entity_completely_parsed()
        pairs.append((first, second))
    return pairs


def as_dictionary(pairs: list[tuple[Any, Any]]) -> dict[Any, Any]:
    """Pairs as a dictionary, with tuples of substitutions as keys."""
    return {tuple(name): value for name, value in pairs}


def children_as_actions(entity: Entity, parser: Parser, *, but: str = "") -> list[Any]:
    """The actions of the nested entities, except those named `but`."""
    children = [child for child in entity.children if child.type_name != but]
    actions: list[Any] = parser.parse_actions(children)
    return actions
