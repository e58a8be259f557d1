"""XML launch files: the parser and its entities, with the line and column of each tag."""

from __future__ import annotations

import re

from launcher.base import xml_tree
from launcher.base.xml_tree import XmlElement, XmlError
from launcher.language.frontends.entity import Entity, SourceText, coerce_text, is_entity_list
from launcher.language.frontends.errors import (
    AttributeTypeError,
    FrontendError,
    MissingAttributeError,
    SourcePlace,
    UnexpectedContentError,
    attribute_hint,
    missing_hint,
    shown,
)
from launcher.language.frontends.parser import Parser, read_text
from launcher.language.naming import read_only

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn
    from xml.etree import ElementTree

MAX_TEXT = 1024 * 1024  # characters; the largest launch files of the field have some 100 KiB


def parse_xml(source: SourceText) -> XmlElement:
    """The root element; FrontendError with the line if the text is not well-formed."""
    if len(source.text) > MAX_TEXT:
        raise FrontendError("the file is too large for a launch file", ros_type="ParseError")
    if not source.text.strip():
        first = SourcePlace(source.path, 1)
        raise FrontendError("the file is empty", place=first, ros_type="ParseError")
    try:
        return xml_tree.parse(source.text)
    except XmlError as problem:
        place = None if problem.line is None else source.place(problem.line, problem.column)
        error = FrontendError(
            problem.message, place=place, hint=problem.hint, ros_type="ParseError"
        )
        raise error from problem


def _of_tree(element: ElementTree.Element) -> XmlElement:
    """A tag that code of others has read, as with ROS 2's class; without places."""
    children = [_of_tree(child) for child in element]
    return XmlElement(element.tag, dict(element.attrib), 0, 0, children)


class XmlEntity(Entity):
    """One tag of an XML launch file; values are coerced to the type that is read."""

    parent: XmlEntity | None = read_only(of="_parent")
    source: SourceText = read_only(of="_source")

    def __init__(
        self,
        xml_element: XmlElement | ElementTree.Element,
        source: SourceText | None = None,
        *,
        parent: XmlEntity | None = None,
    ) -> None:
        if not isinstance(xml_element, XmlElement):
            xml_element = _of_tree(xml_element)
        self._element = xml_element
        self._source = SourceText("<script>", "") if source is None else source
        self._parent = parent
        self._read_attributes: set[str] = set()
        self._read_tags: set[str] = set()

    @property
    def type_name(self) -> str:
        return self._element.name

    @property
    def children(self) -> list[XmlEntity]:
        """All nested tags, which are then all marked as read."""
        self._read_tags = {child.name for child in self._element.children}
        return self._entities(self._element.children)

    @property
    def place(self) -> SourcePlace:
        return self._source.place(self._element.line, self._element.column)

    def assert_entity_completely_parsed(self) -> None:
        """ValueError that names the first unknown tag or attribute."""
        tags = [child.name for child in self._element.children]
        self._note_use([*self._element.attributes, *tags])
        for child in self._element.children:
            if child.name not in self._read_tags:
                self._fail_for_tag(child)
        for name in self._element.attributes:
            if name not in self._read_attributes:
                self._fail_for_attribute(name)

    def get_attr(
        self,
        name: str,
        *,
        data_type: object = str,
        optional: bool = False,
        can_be_str: bool = True,
    ) -> Any:
        """See Entity.get_attr."""
        if is_entity_list(data_type):
            return self._nested(name, optional=optional)
        self._read_attributes.add(name)
        text = self._element.attributes.get(name)
        if text is None:
            return None if optional else self._fail_for_missing(name)
        self._source.note_read(text, self._attribute_place(name))
        separator = self._element.attributes.get(f"{name}-sep")
        if separator is None:
            return self._coerced(name, text, data_type, can_be_str=can_be_str)
        self._read_attributes.add(f"{name}-sep")
        if not separator:
            raise UnexpectedContentError("empty separator", place=self._attribute_place(name))
        return self._coerced(name, text.split(separator), data_type, can_be_str=can_be_str)

    def _coerced(
        self, name: str, text: str | list[str], data_type: object, *, can_be_str: bool
    ) -> Any:
        try:
            return coerce_text(text, data_type, can_be_str=can_be_str)
        except ValueError as problem:
            wanted = getattr(data_type, "__name__", str(data_type))
            raise AttributeTypeError(
                f"attribute '{name}' of <{self.type_name}> should be of type {wanted}, "
                f"'{shown(text)}' is not",
                place=self._attribute_place(name),
            ) from problem

    def _nested(self, name: str, *, optional: bool) -> list[XmlEntity] | None:
        nested = [child for child in self._element.children if child.name == name]
        if not nested:
            return None if optional else self._fail_for_missing_tag(name)
        self._read_tags.add(name)
        return self._entities(nested)

    def _entities(self, elements: list[XmlElement]) -> list[XmlEntity]:
        return [XmlEntity(element, self._source) for element in elements]

    def _attribute_place(self, name: str) -> SourcePlace:
        """Where the value of an attribute begins; the tag, if it cannot be found."""
        found = self._find_attribute(name)
        return self.place if found is None else self._source.place(found[0], found[1].end() + 1)

    def _find_attribute(self, name: str) -> tuple[int, re.Match[str]] | None:
        """(line, `name="` in it): the attribute may be on a line below its tag."""
        start = re.compile(rf"(?<![\w:.-]){re.escape(name)}\s*=\s*[\"']")
        column = self._element.column - 1
        for line in range(self._element.line, len(self._source.lines) + 1):
            found = start.search(self._source.lines[line - 1], column)
            if found:
                return line, found
            column = 0
        return None

    def _fail_for_missing(self, name: str) -> NoReturn:
        unknown = [key for key in self._element.attributes if key not in self._read_attributes]
        hint = missing_hint(self.type_name, name, unknown)
        raise MissingAttributeError(
            f"<{self.type_name}> needs the attribute '{name}'", place=self.place, hint=hint
        )

    def _fail_for_missing_tag(self, name: str) -> NoReturn:
        raise MissingAttributeError(
            f"<{self.type_name}> needs a nested tag <{name}>", place=self.place
        )

    def _fail_for_tag(self, child: XmlElement) -> NoReturn:
        unread = {one.name for one in self._element.children} - set(self._read_tags)
        raise UnexpectedContentError(
            f"<{child.name}> is not allowed inside <{self.type_name}> "
            f"(Unexpected nested tag(s) found in `{self.type_name}`: {unread})",
            place=self._source.place(child.line, child.column),
            hint=attribute_hint(self.type_name, child.name, self._read_tags),
        )

    def _fail_for_attribute(self, name: str) -> NoReturn:
        found = self._find_attribute(name)
        unread = set(self._element.attributes) - set(self._read_attributes)
        raise UnexpectedContentError(
            f"<{self.type_name}> has no attribute '{name}' "
            f"(Unexpected attribute(s) found in `{self.type_name}`: {unread})",
            place=self.place
            if found is None
            else self._source.place(found[0], found[1].start() + 1),
            hint=attribute_hint(self.type_name, name, self._read_attributes),
        )


class XmlParser(Parser):
    """Reads XML."""

    @classmethod
    def load(cls, file: object) -> tuple[XmlEntity, XmlParser]:
        """(root entity, parser) of a path or an open file; FrontendError if it is not XML."""
        source = read_text(file)
        entity = XmlEntity(parse_xml(source), source)
        parser = cls()
        parser.source = source
        return entity, parser

    @classmethod
    def get_file_extensions(cls) -> set[str]:
        """How the names of such files end."""
        return {"launch.xml"}
