"""YAML launch files: the parser and its entities, with the line and column of each key.

Values follow YAML's own rules and are kept beside their nodes, which have line and column.
"""

from __future__ import annotations

from collections.abc import Iterator

import yaml

from launcher.language.frontends.entity import Entity, SourceText, is_entity_list
from launcher.language.frontends.errors import (
    AttributeTypeError,
    FrontendError,
    MissingAttributeError,
    SourcePlace,
    StructureError,
    UnexpectedContentError,
    attribute_hint,
    missing_hint,
    shown,
)
from launcher.language.frontends.parser import Parser, read_text
from launcher.language.frontends.yaml_errors import located
from launcher.language.naming import read_only
from launcher.language.type_utils import is_instance_of

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn


MAX_TEXT = 512 * 1024  # characters; YAML is read at some 100 KiB a second
MAX_NUMBER = 1000  # digits; numbers to base 60 take quadratic time
MAX_NODES = 200_000  # with all aliases expanded
MAX_DEPTH = 120  # a nested action takes two levels

# The key that is meant if an action has a text only.
_MAIN_KEYS = {
    "arg": "name",
    "executable": "cmd",
    "include": "file",
    "log": "message",
    "push_ros_namespace": "namespace",
}


def parse_yaml(source: SourceText) -> tuple[Any, yaml.Node | None]:
    """(value, node) of the document; FrontendError with the line if it is not YAML."""
    if len(source.text) > MAX_TEXT:
        raise FrontendError("the file is too large for a launch file", ros_type="YAMLError")
    try:
        loader = yaml.SafeLoader(source.text)
        node = loader.get_single_node()
        if node is None:
            return None, None
        _check_size(node, source)
        return loader.construct_document(node), node
    except yaml.MarkedYAMLError as problem:
        raise located(problem, source) from problem
    except (yaml.YAMLError, ValueError, TypeError, OverflowError) as problem:
        message = f"invalid YAML: {problem}"
        raise FrontendError(message, ros_type=type(problem).__name__) from problem
    except RecursionError:
        raise FrontendError("this YAML is nested too deeply", ros_type="RecursionError") from None


def _check_size(root: yaml.Node, source: SourceText) -> None:
    """Reject expansion bombs: every alias counts as the nodes that it expands to."""
    sizes: dict[int, int] = {}
    open_nodes: set[int] = set()

    def size(node: yaml.Node, depth: int) -> int:
        if id(node) in sizes:
            return sizes[id(node)]
        if id(node) in open_nodes or depth > MAX_DEPTH:
            problem = "an alias of itself" if id(node) in open_nodes else "nested too deeply"
            place = _place(node, source)
            raise FrontendError(f"this YAML is {problem}", place=place, ros_type="RecursionError")
        if _is_long_number(node):
            raise FrontendError("this number is too long", place=_place(node, source))
        open_nodes.add(id(node))
        total = 1 + sum(size(child, depth + 1) for child in _child_nodes(node))
        open_nodes.discard(id(node))
        sizes[id(node)] = total
        if total > MAX_NODES:
            message = f"this YAML expands to more than {MAX_NODES} values"
            raise FrontendError(message, place=_place(node, source), ros_type="MemoryError")
        return total

    size(root, 0)


def _is_long_number(node: yaml.Node) -> bool:
    is_number = node.tag.endswith((":int", ":float"))
    return is_number and isinstance(node, yaml.ScalarNode) and len(node.value) > MAX_NUMBER


def _child_nodes(node: yaml.Node) -> Iterator[yaml.Node]:
    if isinstance(node, yaml.MappingNode):
        for pair in node.value:
            yield from pair
    elif isinstance(node, yaml.SequenceNode):
        yield from node.value


def _place(node: yaml.Node, source: SourceText) -> SourcePlace:
    return source.place(node.start_mark.line + 1, node.start_mark.column + 1)


class YamlEntity(Entity):
    """One key of a YAML launch file with its value; values are checked, never coerced."""

    type_name: str = read_only(of="_type_name")
    source: SourceText = read_only(of="_source")
    parent: YamlEntity | None = read_only(of="_parent")

    def __init__(
        self,
        element: Any,
        type_name: str,
        source: SourceText | None = None,
        *,
        parent: YamlEntity | None = None,
        node: yaml.Node | None = None,
        key_node: yaml.Node | None = None,
    ) -> None:
        self._element = element
        self._type_name = type_name
        self._source = SourceText("<script>", "") if source is None else source
        self._parent = parent
        self._node = node
        self._key_node = key_node
        self._read_keys: set[Any] = set()
        self._children_read = False

    @property
    def place(self) -> SourcePlace | None:
        """Where its key begins; for an item of a list, where the item begins."""
        node = self._key_node or self._node
        return _place(node, self._source) if node is not None else None

    @property
    def children(self) -> list[YamlEntity]:
        """The items of the list, or of the list under the key `children`."""
        self._children_read = True
        items, node = self._element, self._node
        if isinstance(items, dict):
            if "children" not in items:
                self._fail_for_children()
            self._read_keys.add("children")
            items, node = items["children"], self._value_node("children")
        elif not isinstance(items, list):
            raise self._wrong_shape("a list of actions", "AttributeError")
        if not isinstance(items, list):
            kinds: dict[type, str] = {str: "AttributeError", dict: "RuntimeError"}
            message = f"the children of '{self._type_name}' should be a list of actions"
            ros_type = kinds.get(type(items), "TypeError")
            raise AttributeTypeError(message, place=self.place, ros_type=ros_type)
        nodes = node.value if isinstance(node, yaml.SequenceNode) else [None] * len(items)
        return [self._child(item, at) for item, at in zip(items, nodes, strict=True)]

    def assert_entity_completely_parsed(self) -> None:
        """ValueError that names the first unknown key."""
        self._note_use(self._element if isinstance(self._element, dict) else ())
        if isinstance(self._element, list):
            if not self._children_read:
                message = f"'{self._type_name}' does not take a list of actions"
                raise UnexpectedContentError(message, place=self.place)
            return
        for key in self._element:
            if key not in self._read_keys:
                raise UnexpectedContentError(
                    f"'{self._type_name}' has no attribute '{key}' "
                    f"(Unexpected key(s) found in `{self._type_name}`: {{'{key}'}})",
                    place=self._key_place(key),
                    hint=attribute_hint(self._type_name, str(key), self._read_keys),
                )

    def get_attr(
        self,
        name: str,
        *,
        data_type: Any = str,
        optional: bool = False,
        can_be_str: bool = True,
    ) -> Any:
        """See Entity.get_attr; values are not converted."""
        if not self._has(name):
            self._read_keys.add(name)
            return None if optional else self._fail_for_missing(name)
        self._read_keys.add(name)
        value = self._element[name]
        if is_entity_list(data_type):
            return self._nested(name, value)
        place = self._value_place(name)
        if not is_instance_of(value, data_type, can_be_str):
            raise AttributeTypeError(
                f"'{name}' of '{self._type_name}' should be of type {_type_text(data_type)}, "
                f"it is of type {type(value).__name__}",
                place=place,
                hint=_quoting_hint(value, data_type, self._value_node(name)),
            )
        if place is not None:
            self._source.note_read(value, place)
        return value

    def _has(self, name: str) -> bool:
        if isinstance(self._element, dict):
            return name in self._element
        if isinstance(self._element, list):
            return False
        kind = "AttributeError" if isinstance(self._element, str) else "TypeError"
        raise self._wrong_shape("attributes (a mapping)", kind)

    def _wrong_shape(self, wanted: str, ros_type: str) -> FrontendError:
        found = "nothing" if self._element is None else type(self._element).__name__
        return AttributeTypeError(
            f"'{self._type_name}' takes {wanted}, not {found}",
            place=self.place,
            hint=self._mapping_hint(),
            ros_type=ros_type,
        )

    def _mapping_hint(self) -> str | None:
        """What to write instead of a value that is no mapping."""
        if self._element is None:
            empty = "[]" if self._type_name == "launch" else "{}"
            return f"write '{self._type_name}: {empty}'"
        key = _MAIN_KEYS.get(self._type_name)
        if key is None or not isinstance(self._element, str):
            return None
        return f"write '{self._type_name}: {{{key}: {shown(self._element)}}}'"

    def _nested(self, name: str, value: object) -> list[YamlEntity]:
        if not (isinstance(value, list) and value and isinstance(value[0], dict)):
            raise AttributeTypeError(
                f"'{name}' of '{self._type_name}' should be a list of mappings",
                place=self._value_place(name),
                hint="begin each item with '- '",
                ros_type="IndexError" if value == [] else None,
            )
        node = self._value_node(name)
        nodes = node.value if isinstance(node, yaml.SequenceNode) else [None] * len(value)
        pairs = zip(value, nodes, strict=True)
        return [YamlEntity(item, name, self._source, node=at) for item, at in pairs]

    def _child(self, item: object, node: yaml.Node | None) -> YamlEntity:
        place = _place(node, self._source) if node is not None else self.place
        if item is None:
            message = f"an empty item in the list of '{self._type_name}'"
            raise AttributeTypeError(message, place=place)
        if not isinstance(item, dict) or len(item) != 1:
            raise self._not_one_action(item, node, place)
        ((key, value),) = item.items()
        key_node, value_node = _pair_of_key(node, key)
        return YamlEntity(value, key, self._source, node=value_node, key_node=key_node or node)

    def _not_one_action(
        self, item: object, node: yaml.Node | None, place: SourcePlace | None
    ) -> StructureError:
        message = f"each item of '{self._type_name}' is one action: a mapping with exactly one key"
        hint = "begin each action with '- '" if isinstance(item, dict) else None
        if isinstance(item, dict) and len(item) > 1:
            first, second = list(item)[:2]
            if item[first] is None:  # its attributes are in the column of the action
                second_node, _ = _pair_of_key(node, second)
                place = place if second_node is None else _place(second_node, self._source)
                message = f"'{second}' is beside '{first}' instead of below it"
                hint = f"indent the attributes of '{first}' further than '{first}' itself"
        ros_type = "TypeError" if isinstance(item, (bool, int, float)) else None
        return StructureError(message, place=place, hint=hint, ros_type=ros_type)

    def _value_node(self, name: object) -> yaml.Node | None:
        return _pair_of_key(self._node, name)[1]

    def _value_place(self, name: object) -> SourcePlace | None:
        node = self._value_node(name)
        return _place(node, self._source) if node is not None else self.place

    def _key_place(self, key: Any) -> SourcePlace | None:
        node, _ = _pair_of_key(self._node, key)
        return self.place if node is None else _place(node, self._source)

    def _fail_for_missing(self, name: str) -> NoReturn:
        unknown = [str(key) for key in self._element if key not in self._read_keys]
        hint = missing_hint(self.type_name, name, unknown)
        raise MissingAttributeError(
            f"'{self._type_name}' needs the attribute '{name}'", place=self.place, hint=hint
        )

    def _fail_for_children(self) -> NoReturn:
        raise UnexpectedContentError(
            f"'{self._type_name}' should hold a list of actions, or a key 'children' with one",
            place=self.place,
        )


def _pair_of_key(
    node: yaml.Node | None, name: object
) -> tuple[yaml.Node, yaml.Node] | tuple[None, None]:
    """(key, value) of a mapping; of equal keys the last one, whose value counts."""
    pairs = node.value if isinstance(node, yaml.MappingNode) else []
    found = [pair for pair in pairs if pair[0].value == str(name)]
    return found[-1] if found else (None, None)


def _type_text(data_type: object) -> str:
    return "a parameter" if data_type is None else getattr(data_type, "__name__", str(data_type))


def _quoting_hint(value: object, data_type: object, node: yaml.Node | None) -> str | None:
    if data_type is str and isinstance(value, (bool, int, float)):
        text = node.value if isinstance(node, yaml.ScalarNode) else str(value).lower()
        return f'quote it: "{text}"'
    return None


class YamlParser(Parser):
    """Reads YAML."""

    @classmethod
    def load(cls, file: object) -> tuple[YamlEntity, YamlParser]:
        """(root entity, parser) of a path or an open file; FrontendError if it is not YAML."""
        source = read_text(file)
        tree, node = parse_yaml(source)
        if not isinstance(tree, dict):
            message = "a YAML launch file is a mapping with the single key 'launch'"
            raise AttributeTypeError(message, place=source.place(1))
        if len(tree) != 1:
            raise StructureError("Expected only one root", place=source.place(1))
        ((type_name, element),) = tree.items()
        key_node, value_node = _pair_of_key(node, type_name)
        entity = YamlEntity(element, type_name, source, node=value_node, key_node=key_node or node)
        parser = cls()
        parser.source = source
        return entity, parser

    @classmethod
    def get_file_extensions(cls) -> set[str]:
        """How the names of such files end."""
        return {"launch.yaml"}
