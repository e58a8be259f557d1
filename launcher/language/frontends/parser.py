"""Parser: selects the format of a file, and converts its entities to actions."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path

from launcher.base import text_file
from launcher.base.errors import LauncherError, LaunchFileError
from launcher.language import frontend_registry
from launcher.language.description import LaunchDescription
from launcher.language.diagnostics.origin import FileLine
from launcher.language.frontends import expose, grammar, grammar_substitutions
from launcher.language.frontends.entity import Entity, SourceText
from launcher.language.frontends.errors import (
    FrontendError,
    SourcePlace,
    StructureError,
    count_of,
    first_of,
    locate,
    of_others,
)
from launcher.language.naming import public
from launcher.language.sources import InvalidLaunchFileError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.action import Action
    from launcher.language.substitution import Substitution

PARSER_GROUP = "launch.frontend.parser"
BUILTIN_SUFFIXES = ("xml", "yaml")
MAX_PROBLEMS = 20  # reported at once


@public("launch.frontend.parser")
class InvalidFrontendLaunchFileError(InvalidLaunchFileError):
    """An XML or YAML launch file is not valid; for launch files that import it."""


class Parser:
    """Converts entities to actions; subclasses read one format each and override `load`."""

    source: SourceText | None = None  # of the file that this parser was made for

    @classmethod
    def load(cls, file: object) -> tuple[Entity, Parser]:
        """(root entity, parser) of a path or an open file.

        The format that the name suggests is tried first, then the others. If none fits, the
        error is that of the first one, followed by the others if the suffix is unknown.
        """
        suffix = Path(str(getattr(file, "name", file))).suffix[1:]
        problems: list[LaunchFileError] = []
        likely = suffix if suffix in BUILTIN_SUFFIXES else _guess(file)
        for implementation in cls._by_likelihood(likely):
            try:
                return implementation.load(file)
            except LaunchFileError as problem:
                problems.append(problem)
                if hasattr(file, "seek"):
                    file.seek(0)
        raise problems[0] if suffix in BUILTIN_SUFFIXES else first_of(problems)

    @classmethod
    def _by_likelihood(cls, suffix: str) -> Iterator[type[Parser]]:
        builtin = sorted(BUILTIN_SUFFIXES, key=lambda name: (name != suffix, name))
        yield from map(cls.get_parser_from_extension, builtin)
        for name in cls.get_available_extensions():  # slow, and rarely needed
            if name not in builtin:
                yield cls.get_parser_from_extension(name)

    @classmethod
    def get_available_extensions(cls) -> list[str]:
        """Suffixes that have a parser, without the dot."""
        from importlib.metadata import entry_points

        installed = [point.name for point in entry_points(group=PARSER_GROUP)]
        return sorted({*BUILTIN_SUFFIXES, *installed})

    @classmethod
    def is_extension_valid(cls, extension: str) -> bool:
        """Whether there is a parser for files with this suffix."""
        return extension in cls.get_available_extensions()

    @classmethod
    def get_parser_from_extension(cls, extension: str) -> type[Parser]:
        """The parser class for a suffix; RuntimeError if there is none."""
        parser: type[Parser]
        if extension in BUILTIN_SUFFIXES:
            parser = frontend_registry.parser_class(extension)
            return parser
        from importlib.metadata import entry_points

        for point in entry_points(group=PARSER_GROUP, name=extension):
            parser = point.load()
            return parser
        raise StructureError("Not recognized frontend implementation")

    @classmethod
    def load_launch_extensions(cls) -> None:
        """Import the packages that expose actions or substitutions."""
        for failure in expose.load_extensions():
            warnings.warn(f"Failed to load the launch extension {failure}", stacklevel=2)

    @classmethod
    def load_parser_implementations(cls) -> None:
        """Import the parsers of other packages."""
        for point in expose.installed(PARSER_GROUP):
            try:
                point.load()
            except Exception as problem:  # one broken package must not hide the others
                warnings.warn(f"Failed to load the parser {point.name}: {problem}", stacklevel=2)

    def parse_description(self, entity: Entity) -> LaunchDescription:
        """The launch description of a root entity; errors of all actions are reported together."""
        if entity.type_name != "launch":
            raise StructureError(
                f"the root of a launch file must be 'launch', not '{entity.type_name}'",
                place=entity.place,
            )
        deprecated = entity.get_attr("deprecated", optional=True)
        actions = self.parse_actions(entity.children)
        description = LaunchDescription(actions, deprecated_reason=deprecated)
        if entity.place is not None:
            description._origin = FileLine(entity.place.path, entity.place.line)
        return description

    def parse_actions(self, entities: Iterable[Entity]) -> list[Action]:
        """The actions of sibling entities; all errors are reported together."""
        actions: list[Action] = []
        problems: list[LaunchFileError] = []
        for entity in entities:
            try:
                actions.append(self.parse_action(entity))
            except LaunchFileError as problem:
                problems.append(problem)
                if sum(map(count_of, problems)) >= MAX_PROBLEMS:
                    break
        if problems:
            raise first_of(problems)
        return actions

    def parse_action(self, entity: Entity) -> Action:
        """The action of one entity; every error gets its place."""
        place = entity.place
        try:
            action = expose.instantiate_action(entity, self)
        except LaunchFileError as error:
            locate(error, place)
            raise
        except (LauncherError, RecursionError):
            raise
        except Exception as problem:
            ros_type = getattr(problem, "ros_type", type(problem).__name__)
            raise of_others(problem, place, f"<{entity.type_name}>", ros_type) from problem
        if place is not None:
            action._origin = FileLine(place.path, place.line)
        return action

    def parse_substitution(self, value: str) -> list[Substitution]:
        """The substitutions of a text."""
        return grammar_substitutions.parse_substitution(value, self._place_of(value))

    def parse_if_substitutions(self, value: object) -> Any:
        """Substitutions if the value is a text that contains some, else the value."""
        return grammar_substitutions.parse_if_substitutions(value, self._place_of(value))

    def _place_of(self, value: object) -> SourcePlace | None:
        return self.source.place_of(value) if self.source is not None else None

    def escape_characters(self, value: str) -> str:
        """A text without its backslashes."""
        return grammar.unescape(value)


def _guess(file: object) -> str:
    """The suffix that a file without one should have, from its first character."""
    if not isinstance(file, (str, Path)) or not Path(file).is_file():
        return ""
    with open(file, "rb") as stream:
        return "xml" if stream.read(200).lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<") else "yaml"


def read_text(file: Any) -> SourceText:
    """The text of a path or an open file; FrontendError if it cannot be read or decoded."""
    path = str(getattr(file, "name", file))
    try:
        text = file.read() if hasattr(file, "read") else text_file.read(file)
    except UnicodeDecodeError as problem:
        wrong = problem.object[problem.start]
        raise FrontendError(
            f"the byte 0x{wrong:02x} is not UTF-8",
            place=SourcePlace(path, problem.object.count(b"\n", 0, problem.start) + 1),
            hint="save the file as UTF-8",
            ros_type="UnicodeDecodeError",
        ) from problem
    except OSError as problem:
        message = f"cannot read {path}: {problem.strerror}"
        raise FrontendError(message, ros_type=type(problem).__name__) from problem
    if text_file.is_pointer(text):
        raise FrontendError(
            text_file.pointer_sentence("it"),
            place=SourcePlace(path, 1),
            hint=text_file.POINTER_HINT,
        )
    return SourceText(path, text)


def __getattr__(name: str) -> Any:
    """`importlib_metadata`, which tests of extensions patch; imported only for them."""
    if name == "importlib_metadata":
        from importlib import metadata

        return metadata
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
