"""XML launch files."""

from __future__ import annotations

from launcher.frontends.entity_xml import XmlEntity, parse_xml
from launcher.frontends.parser import Parser, read_text
from launcher.language.description import LaunchDescription

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


class XmlParser(Parser):
    """Reads XML."""

    @classmethod
    def load(cls, file: Any) -> tuple[XmlEntity, XmlParser]:
        """(root entity, parser) of a path or an open file; FrontendError if it is no XML."""
        source = read_text(file)
        entity = XmlEntity(parse_xml(source), source)
        parser = cls()
        parser.source = source
        return entity, parser

    @classmethod
    def get_file_extensions(cls) -> set[str]:
        """How the names of such files end."""
        return {"launch.xml"}


def load(path: str) -> LaunchDescription:
    """The launch description of an XML file."""
    entity, parser = XmlParser.load(path)
    return parser.parse_description(entity)
