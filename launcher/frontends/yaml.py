"""YAML launch files."""

from __future__ import annotations

from launcher.frontends.entity_errors import AttributeTypeError, StructureError
from launcher.frontends.entity_yaml import YamlEntity, key_of, node_of_key, parse_yaml
from launcher.frontends.parser import Parser, read_text
from launcher.language.description import LaunchDescription

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


class YamlParser(Parser):
    """Reads YAML."""

    @classmethod
    def load(cls, file: Any) -> tuple[YamlEntity, YamlParser]:
        """(root entity, parser) of a path or an open file; FrontendError if it is no YAML."""
        source = read_text(file)
        tree, node = parse_yaml(source)
        if not isinstance(tree, dict):
            message = "a YAML launch file is a mapping with the one key 'launch'"
            raise AttributeTypeError(message, place=source.place(1))
        if len(tree) != 1:
            raise StructureError("Expected only one root", place=source.place(1))
        ((type_name, element),) = tree.items()
        value_node = node_of_key(node, type_name)
        entity = YamlEntity(element, type_name, source, node=value_node, key_node=key_of(node))
        parser = cls()
        parser.source = source
        return entity, parser

    @classmethod
    def get_file_extensions(cls) -> set[str]:
        """How the names of such files end."""
        return {"launch.yaml"}


def load(path: str) -> LaunchDescription:
    """The launch description of a YAML file."""
    entity, parser = YamlParser.load(path)
    return parser.parse_description(entity)
