"""XML files as trees, with the line and column of each tag.

ElementTree drops line numbers, so expat is used directly. Bounds on depth and entity declarations
bound time and memory for malicious files.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from xml.parsers import expat

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn

_MAX_DEPTH = 60  # nested tags; each level costs Python frames while actions are parsed
_MAX_ENTITY = 256  # characters that one `&name;` may stand for; it may not hold another one


@dataclass(slots=True)
class XmlElement:
    """One tag: its attributes as written, its place (line and column from 1), its content.

    `text` is "" for a tag with children.
    """

    name: str
    attributes: dict[str, str]
    line: int
    column: int
    children: list[XmlElement] = field(default_factory=list)
    text: str = ""
    end_line: int = 0  # of its end tag


class XmlError(Exception):
    """A text that is not XML, or beyond the bounds; an unknown encoding has no line."""

    def __init__(
        self, message: str, line: int | None = None, column: int = 1, hint: str | None = None
    ) -> None:
        super().__init__(message)
        self.message = message
        self.line = line
        self.column = column
        self.hint = hint


def parse(text: str) -> XmlElement:
    """The root element. XmlError if the text is not well-formed."""
    builder = _TreeBuilder()
    try:
        return builder.parse(text)
    except (LookupError, ValueError) as problem:  # an unknown encoding
        raise XmlError(f"invalid XML: {problem}") from problem
    except expat.ExpatError as problem:
        message = expat.errors.messages.get(problem.code, str(problem))
        hint = _token_hint(text, problem) or builder.open_tag_hint()
        raise XmlError(message, problem.lineno, problem.offset + 1, hint) from problem


def _token_hint(text: str, problem: expat.ExpatError) -> str | None:
    """What to write if a character that begins a tag or an entity is where it must not be."""
    if "invalid token" not in expat.errors.messages.get(problem.code, ""):
        return None
    lines = text.split("\n")[: problem.lineno]  # as expat counts them
    line = lines[-1]
    if "&" in line[max(problem.offset - 1, 0) : problem.offset + 1]:
        return "write &amp; for a literal '&'"
    before = "\n".join([*lines[:-1], line[: problem.offset]])
    begin = before.rfind("<")
    found = re.match(r"[\w:.-]+", before[begin + 1 :])
    if line[problem.offset : problem.offset + 1] != "<" or begin < before.rfind(">") or not found:
        return None
    return f"<{found[0]} in line {before.count(chr(10), 0, begin) + 1} has no '>' at its end"


class _TreeBuilder:
    def __init__(self) -> None:
        self._open: list[XmlElement] = []
        self._root: XmlElement | None = None
        self._text: list[str] = []  # since the last tag
        self._expat = expat.ParserCreate(namespace_separator="}")
        self._expat.buffer_text = True
        self._expat.StartElementHandler = self._start
        self._expat.EndElementHandler = self._end
        self._expat.CharacterDataHandler = self._text.append
        self._expat.EntityDeclHandler = self._entity_declaration
        self._expat.ExternalEntityRefHandler = lambda *_: 0

    def parse(self, text: str) -> XmlElement:
        # As bytes, so that a declared encoding is used, as by ElementTree.
        self._expat.Parse(text.encode(errors="surrogatepass"), True)
        assert self._root is not None  # expat rejects a file without a root
        return self._root

    def open_tag_hint(self) -> str | None:
        """The tag that was open where parsing failed."""
        if not self._open:
            return None
        tag = self._open[-1]
        return f"<{tag.name}> in line {tag.line} is not closed"

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        element = XmlElement(
            name=_qualified(name),
            attributes={_qualified(key): value for key, value in attributes.items()},
            line=self._expat.CurrentLineNumber,
            column=self._expat.CurrentColumnNumber + 1,
        )
        if len(self._open) >= _MAX_DEPTH:
            self._refuse(f"tags are nested more than {_MAX_DEPTH} deep")
        if self._open:
            self._open[-1].children.append(element)
        else:
            self._root = element
        self._open.append(element)
        self._text.clear()

    def _end(self, name: str) -> None:
        element = self._open.pop()
        element.end_line = self._expat.CurrentLineNumber
        if not element.children:
            element.text = "".join(self._text)
        self._text.clear()

    def _entity_declaration(
        self, name: str, is_parameter: bool, value: str | None, *rest: str | None
    ) -> None:
        if is_parameter or value is None:
            self._refuse(f"the XML entity '{name}' is defined outside of the file")
        elif len(value) > _MAX_ENTITY or "&" in value:
            self._refuse(f"the XML entity '{name}' is too long or refers to another one")

    def _refuse(self, message: str) -> NoReturn:
        raise XmlError(message, self._expat.CurrentLineNumber, self._expat.CurrentColumnNumber + 1)


def _qualified(name: str) -> str:
    return "{" + name if "}" in name else name
