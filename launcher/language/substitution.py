"""Base class of substitutions; a list of them is one text, joined when it is performed."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence

from launcher.language import frontend_registry
from launcher.language.class_tools import ensure_argument_type, is_a_subclass, is_path
from launcher.language.diagnostics.origin import FileLine, caller_origin, is_own_file
from launcher.language.naming import public, read_only

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

# Characters of a text that substitutions make; a robot's description with all meshes has 1 million.
MAX_TEXT = 16 * 1024 * 1024
_MAX_SHOWN = 120


@public("launch.substitution")
class Substitution:
    """Base of every substitution; subclasses override `perform` and may override `describe`."""

    _origin: FileLine | None

    def __new__(cls, *args: object, **kwargs: object) -> Any:
        """Remember the place of creation."""
        substitution = super().__new__(cls)
        substitution._origin = caller_origin()
        return substitution

    def __init__(self) -> None:
        """Nothing to set; subclasses call it."""

    @classmethod
    def parse(cls, data: Sequence[Any]) -> Any:
        """(class, keyword arguments) for the words of `$(name word ...)` in XML and YAML."""
        return frontend_registry.parse_with("Substitution", cls, data)

    def describe(self) -> str:
        return self.__repr__()

    def __str__(self) -> str:
        """As in ROS 2, what `repr` gives; a warning if the launch file takes it for a text."""
        frame = sys._getframe(1)
        if not is_own_file(frame.f_code.co_filename):
            # Imported only for a warning.
            from launcher.language.diagnostics.text_uses import warn_of_str

            warn_of_str(self, frame)
        return self.__repr__()

    def __eq__(self, other: object) -> bool:
        """As in ROS 2, only identity; a warning if the launch file compares it with a text."""
        if isinstance(other, str):
            frame = sys._getframe(1)
            if not is_own_file(frame.f_code.co_filename):
                # Imported only for a warning.
                from launcher.language.diagnostics.text_uses import warn_of_comparison

                warn_of_comparison(self, other, frame)
        return NotImplemented

    __hash__ = object.__hash__

    def perform(self, context: LaunchContext) -> str:
        """The text; NotImplementedError if a subclass has no such method."""
        # Imported only for an error.
        from launcher.language.diagnostics.base_classes import NoPerformError

        raise NoPerformError(self)


SomeSubstitutionsType_types_tuple = (str, Substitution, Iterable)


@public("launch.substitutions.substitution_failure")
class SubstitutionFailure(Exception):
    """A substitution could not be performed."""


@public("launch.substitutions.text_substitution")
class TextSubstitution(Substitution):
    """A literal text."""

    text: str = read_only()

    def __init__(self, *, text: str) -> None:
        ensure_argument_type(text, str, "text", "TextSubstitution")
        self.__text = text

    def describe(self) -> str:
        return f"'{self.text}'"

    def perform(self, context: LaunchContext) -> str:
        return self.text


def normalize_to_list_of_substitutions(subs: Any) -> list[Substitution]:
    """One text, path or substitution, or several of them, as a list of substitutions."""
    if isinstance(subs, str):
        return [TextSubstitution(text=subs)]
    if is_a_subclass(subs, Substitution):
        return [subs]
    if is_path(subs):
        return [TextSubstitution(text=str(subs))]
    if isinstance(subs, bytes) or hasattr(type(subs), "__fspath__"):
        subs = [subs]  # refused below, and not for what iterating it gives
    return [_as_substitution(item) for item in subs]


def _as_substitution(item: object) -> Substitution:
    if isinstance(item, str):
        return TextSubstitution(text=item)
    if is_a_subclass(item, Substitution):
        assert isinstance(item, Substitution)
        return item
    if is_path(item):
        return TextSubstitution(text=str(item))
    raise TypeError(
        f"Failed to normalize given item of type '{type(item)}', when only "
        f"'str' or 'launch.Substitution' were expected."
    )


def optional_substitutions(subs: object) -> list[Substitution] | None:
    """Like `normalize_to_list_of_substitutions`; None stays None."""
    return None if subs is None else normalize_to_list_of_substitutions(subs)


def perform_substitutions(context: LaunchContext, subs: Any) -> str:
    """The texts of the substitutions, joined."""
    return joined(subs, [context.perform_substitution(sub) for sub in subs])


def joined(subs: Any, texts: Sequence[str]) -> str:
    """The texts that the substitutions gave as one; TypeError if one of them is no text.

    SubstitutionFailure if it is longer than MAX_TEXT.
    """
    try:
        if sum(map(len, texts)) > MAX_TEXT:
            raise too_long(describe_substitutions(subs))
        return "".join(texts)
    except TypeError:
        # Imported only for an error.
        from launcher.language.diagnostics.wrong_returns import no_text

        raise no_text(subs, texts) from None


def too_long(what: str) -> SubstitutionFailure:
    """The error about a text that is longer than MAX_TEXT."""
    shown = what if len(what) <= _MAX_SHOWN else f"{what[:_MAX_SHOWN]}..."
    return SubstitutionFailure(f"the text of {shown} has more than {MAX_TEXT:,} characters")


def perform(context: LaunchContext, subs: object) -> str:
    """The text of one text, one substitution or several of them, before normalisation."""
    return perform_substitutions(context, normalize_to_list_of_substitutions(subs))


def plain_text(subs: Iterable[Substitution]) -> str | None:
    """The joined texts if all substitutions are TextSubstitutions, else None."""
    texts = []
    for sub in subs:
        if not isinstance(sub, TextSubstitution):
            return None
        texts.append(sub.text)
    return "".join(texts)


def describe_substitutions(subs: Iterable[Substitution]) -> str:
    """The descriptions of the substitutions, joined by plus signs."""
    return " + ".join([description_of(sub) for sub in subs])


def description_of(part: Any) -> str:
    """What a substitution or a condition says of itself, without addresses of objects.

    `describe` of a launch file's own class may fail or say nothing, and some of ROS 2 give
    addresses of their operands: then the class with its operands, if it has any.
    """
    try:
        text = part.describe()
    except Exception:
        text = None
    if isinstance(text, str) and text.strip() and " object at 0x" not in text:
        return text
    name, operands = type(part).__name__, getattr(part, "_operands", None)
    return f"{name}({', '.join(map(describe_substitutions, operands))})" if operands else name
