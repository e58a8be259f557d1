"""Loads Python, XML and YAML launch files.

Importing this package registers the parsers with the language; they are imported on first use.
"""

from __future__ import annotations

from launcher.base.errors import LaunchFileError
from launcher.language import frontend_registry
from launcher.language.description import LaunchDescription
from launcher.language.sources import get_launch_description_from_any_launch_file

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.substitution import Substitution


class NoDescriptionError(LaunchFileError):
    """`generate_launch_description()` did not return a LaunchDescription."""

    ros_type = "AttributeError"
    stage = "run"  # ROS 2 raises it when it visits the result


def load(path: str) -> LaunchDescription:
    """The description in a launch file; the vocabulary must be open (language.compat).

    Raises LaunchFileError with the place in the file; its `__cause__` is the original exception.
    """
    try:
        description = get_launch_description_from_any_launch_file(path)
    except (Exception, SystemExit) as error:
        from launcher.language.diagnostics import faults

        raise faults.explain(error, path) from error.__cause__ or error
    if not isinstance(description, LaunchDescription):
        raise _no_description(path, description)
    return description


def _no_description(path: str, result: object) -> NoDescriptionError:
    import linecache

    from launcher.language.diagnostics.bad_entries import place_of_return, returned_instead

    place = place_of_return(path, "generate_launch_description")
    line = linecache.getline(path, place.line).rstrip("\n") if place else ""
    return NoDescriptionError(
        f"generate_launch_description() returned {type(result).__name__}, not a LaunchDescription",
        where=f"{path}:1" if place is None else str(place),
        hint=returned_instead(path, result),
        source_line=line or None,
        column=len(line) - len(line.lstrip()) + 1 if line else None,
    )


def _parser_class(extension: str) -> Any:
    if extension == "xml":
        from launcher.language.frontends.xml import XmlParser

        return XmlParser
    if extension == "yaml":
        from launcher.language.frontends.yaml import YamlParser

        return YamlParser
    from launcher.language.frontends.parser import Parser

    return Parser


def _parse(key: str, *args: object, **kwargs: object) -> Any:
    from launcher.language.frontends.parsers import tables

    return tables.parse_function(key)(*args, **kwargs)


def _parse_substitution(text: str) -> list[Substitution]:
    from launcher.language.frontends.grammar_substitutions import parse_substitution

    return parse_substitution(text)


frontend_registry.provide(
    parse_with=_parse, parse_substitution=_parse_substitution, parser_class=_parser_class
)
