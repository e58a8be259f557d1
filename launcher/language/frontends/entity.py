"""Entity: the interface of XML tags and YAML keys for `parse` methods."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, List, get_args, get_origin  # noqa: UP035 - List[...] is the API

from launcher.base.text import did_you_mean
from launcher.language import launch_session
from launcher.language.diagnostics.origin import FileLine
from launcher.language.frontends.errors import SourcePlace, UnexpectedContentError
from launcher.language.type_utils import get_typed_value

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


class SourceText:
    """The text of a launch file, and the place of the attribute that was read last."""

    def __init__(self, path: str, text: str) -> None:
        self.path = path
        self.text = text
        self._lines: list[str] | None = None
        self._last_read: tuple[str, SourcePlace] | None = None

    @property
    def lines(self) -> list[str]:
        """The lines without their ends."""
        if self._lines is None:
            # Lines as expat counts them: splitlines() splits at more characters.
            self._lines = self.text.split("\n")
        return self._lines

    def place(self, line: int, column: int | None = None) -> SourcePlace:
        """A spot with the text of its line; line and column from 1."""
        source_line = self.lines[line - 1] if 0 < line <= len(self.lines) else None
        return SourcePlace(self.path, line, column, source_line)

    def note_read(self, value: object, place: SourcePlace) -> None:
        """Remember where the text was read: it is parsed next."""
        if isinstance(value, str):
            self._last_read = (value, place)

    def place_of(self, value: object) -> SourcePlace | None:
        """The place of this text, if it was read last."""
        if self._last_read is not None and self._last_read[0] == value:
            return self._last_read[1]
        return None


class Entity:
    """Interface of the entities of all front ends.

    An entity records what is read from it, so that unknown attributes and tags are found.
    """

    @property
    def type_name(self) -> str:
        """The tag, or the key."""
        raise NotImplementedError

    @property
    def parent(self) -> Entity | None:
        """None: ROS 2's front ends do not provide it."""
        return None

    @property
    def children(self) -> Sequence[Entity]:
        """The entities within this one."""
        raise NotImplementedError

    @property
    def place(self) -> SourcePlace | None:
        """Its position, if it comes from a file."""
        return None

    @property
    def source(self) -> SourceText | None:
        """The file that it comes from, if any."""
        return None

    def _note_use(self, names: Iterable[object]) -> None:
        """Note the tag, and its attributes and nested tags, for warnings about what is new."""
        current, place = launch_session.current(), self.place
        if current.watched and place is not None:
            where = FileLine(place.path, place.line)
            for one in ("", *(f" {name}" for name in names)):
                current.note_use(f"<{self.type_name}{one}>", where)

    def assert_entity_completely_parsed(self) -> None:
        """ValueError if there is an attribute or a nested entity that was not read."""
        raise NotImplementedError

    def get_attr(
        self,
        name: str,
        *,
        data_type: object = str,
        optional: bool = False,
        can_be_str: bool = True,
    ) -> Any:
        """The value of an attribute as a `data_type`; None if it is optional and not there.

        `data_type` is bool, int, float, str, a `List` of one of these, `List[Entity]` for nested
        entities of this name, or None for the type that YAML gives the text. With `can_be_str` a
        text that cannot be converted is returned, since it may contain substitutions.
        AttributeError if it is missing, TypeError if it has another type.
        """
        raise NotImplementedError


MAX_TYPED = 100_000  # characters; longer texts (a robot description) are not converted

# Values of the attribute `type` of a parameter.
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
    raise UnexpectedContentError(
        f"unknown type '{identifier}', expected one of: {known}", hint=hint
    )


def is_entity_list(data_type: object) -> bool:
    """Whether the type is `List[Entity]`, or a list of a subclass."""
    if get_origin(data_type) is not list:
        return False
    (member,) = get_args(data_type)
    return isinstance(member, type) and issubclass(member, Entity)


def coerce_text(text: str | list[str], data_type: object, *, can_be_str: bool) -> Any:
    """Convert the text of an XML attribute, or its pieces.

    ValueError if it cannot be converted, TypeError if pieces are given for a scalar.
    """
    if len(text) > MAX_TYPED and isinstance(text, str) and can_be_str:
        return text
    return get_typed_value(text, data_type, can_be_str)
