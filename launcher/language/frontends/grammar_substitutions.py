"""Parses the text of an attribute into substitutions."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.base.text import did_you_mean
from launcher.language import frontend_registry
from launcher.language.diagnostics.origin import FileLine
from launcher.language.frontends import expose
from launcher.language.frontends.errors import (
    FrontendError,
    SourcePlace,
    StructureError,
    as_lark_error,
    locate,
    of_others,
    shown,
)
from launcher.language.frontends.grammar import (
    GrammarError,
    Part,
    SubstitutionCall,
    Text,
    parse_template,
)
from launcher.language.launch_session import current
from launcher.language.substitution import Substitution, TextSubstitution

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

# Substitutions of ROS 1 and of other languages, and what to use instead.
_OTHER_WORDS = {
    "eq": "did you mean 'equals'?",
    "ne": "did you mean 'not-equals'?",
    "neq": "did you mean 'not-equals'?",
    "find": "in ROS 2, write $(find-pkg-share PACKAGE)",
    "arg": "in ROS 2, write $(var NAME)",
    "optenv": "in ROS 2, write $(env NAME DEFAULT)",
}


def parse_substitution(value: str, place: SourcePlace | None = None) -> list[Substitution]:
    """The substitutions of a template; `place` is where it begins in the launch file.

    FrontendError for invalid syntax, an unknown substitution or wrong arguments.
    """
    try:
        parts = parse_template(value)
    except GrammarError as problem:
        raise as_lark_error(_syntax_error(value, problem, place)) from None
    try:
        return [_build(part, place) for part in parts]
    except FrontendError as error:
        as_lark_error(error)
        raise


def parse_if_substitutions(value: object, place: SourcePlace | None = None) -> Any:
    """Substitutions if the value is a text that contains some, else the value.

    Items of a list are parsed one by one; ValueError if their types then differ.
    """
    kinds: set[type] = set()
    if isinstance(value, list):
        output: Any = [_parse_if(item, kinds, place) for item in value]
    else:
        output = _parse_if(value, kinds, place)
    if len(kinds) > 1:
        raise ValueError("The result is a non-uniform list")
    return output


def _parse_if(value: object, kinds: set[type], place: SourcePlace | None) -> Any:
    if not isinstance(value, str):
        kinds.add(type(value))
        return value
    substitutions = parse_substitution(value, place)
    if len(substitutions) == 1 and isinstance(substitutions[0], TextSubstitution):
        kinds.add(str)
        return substitutions[0].text
    return substitutions


def _build(part: Part, place: SourcePlace | None) -> Substitution:
    if isinstance(part, Text):
        substitution: Substitution = TextSubstitution(text=part.text)
    else:
        words = [[_build(piece, place) for piece in word] for word in part.words]
        substitution = _call(part, words, place)
    if place is not None:
        substitution._origin = FileLine(place.path, place.line)
    return substitution


def _call(
    call: SubstitutionCall, words: Sequence[list[Substitution]], place: SourcePlace | None
) -> Substitution:
    here = _shifted(place, call.position)
    method = expose.substitution_parser(call.name)
    if method is None:
        from launcher.language.diagnostics import proposed_names  # only for an error

        hint = _OTHER_WORDS.get(call.name) or proposed_names.of_word(call.name)
        hint = hint or did_you_mean(call.name, expose.substitution_names())
        hint = hint or expose.failed_extensions()
        message = f"unknown substitution $({call.name} ...)"
        raise StructureError(message, place=here, hint=hint, ros_type="VisitError")
    if here is not None and call.name not in frontend_registry.substitution_parse_methods:
        current().note_use(f"$({call.name})", FileLine(here.path, here.line))
    try:
        substitution_type, arguments = expose.class_and_arguments(method, method(words))
        made: Substitution = substitution_type(**arguments)
    except FrontendError as error:
        locate(error, here)
        raise
    except Exception as problem:
        raise of_others(problem, here, f"$({call.name} ...)", "VisitError") from problem
    return made


def _syntax_error(value: str, problem: GrammarError, place: SourcePlace | None) -> FrontendError:
    return FrontendError(
        f"in '{shown(value)}': {problem}",
        place=_shifted(place, problem.position),
        hint=r"write '\$(' for a literal '$('" if problem.at_end else None,
        ros_type="UnexpectedEOF" if problem.at_end else "UnexpectedCharacters",
    )


def _shifted(place: SourcePlace | None, characters: int) -> SourcePlace | None:
    """The place moved right within its line; approximate if the line contains escapes."""
    if place is None or place.column is None or place.source_line is None:
        return place
    column = place.column + characters
    if column > len(place.source_line) + 1:
        return place
    return SourcePlace(place.path, place.line, column, place.source_line)
