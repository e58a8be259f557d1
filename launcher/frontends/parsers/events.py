"""`log` and `shutdown`."""

from __future__ import annotations

from typing import Any

from launcher.frontends.entity import Entity
from launcher.frontends.parsers.base import Parsed, add_texts, parse_action, parse_texts


def parse_log(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`log`."""
    return parse_texts(cls, entity, parser, {"msg": "message"})


def parse_shutdown(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`shutdown`."""
    _, arguments = parse_action(cls, entity, parser)
    add_texts(arguments, entity, parser, {"reason": "reason"}, optional=True)
    return cls, arguments
