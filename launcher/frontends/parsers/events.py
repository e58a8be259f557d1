"""`log` and `shutdown`."""

from __future__ import annotations

from launcher.frontends.entity import Entity
from launcher.frontends.parsers.base import Parsed, parse_action, parse_texts
from launcher.language.substitution import TextSubstitution

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def parse_log(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`log`; newer releases of ROS 2 know an attribute `level`."""
    _, arguments = parse_texts(cls, entity, parser, {"msg": "message"})
    level = entity.get_attr("level", optional=True)
    if level is None:
        return cls, arguments
    from launcher.language.actions.logs import Log

    return Log, {**arguments, "level": parser.parse_substitution(level)}


def parse_shutdown(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`shutdown`; a reason without substitutions is handed on as the text that it is."""
    _, arguments = parse_action(cls, entity, parser)
    reason = entity.get_attr("reason", optional=True)
    if reason:
        parts = parser.parse_substitution(reason)
        texts = [part.text for part in parts if isinstance(part, TextSubstitution)]
        arguments["reason"] = "".join(texts) if len(texts) == len(parts) else parts
    return cls, arguments
