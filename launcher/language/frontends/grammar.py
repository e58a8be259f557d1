"""The `$(...)` language: text of a launch file to a tree of texts and calls.

Three kinds of context exist: bare (the words of a call), and between single or double quotes. A
backslash escapes the character after it. One space separates the words of a call; a word is either
quoted as a whole or contains no quote, space or bare parenthesis.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn

MAX_DEPTH = 40  # of nested calls; bounds the recursion

_NAME = "[A-Za-z][A-Za-z0-9_-]*"
_ESCAPED = r"\\(.)"

# Runs of text by context. A dollar sign is text unless an unescaped `(`
# follows it; only in words does a parenthesis need a backslash. Patterns are compiled when they
# are first needed: most texts of most launch files need none.
_DOLLAR = r"\$(?!\()|(?<=\\)\$"
_TEMPLATE_TEXT = rf"(?:[^$]|{_DOLLAR})+"
_QUOTED_TEXT = {quote: rf"(?:\\{quote}|[^{quote}\\$]|{_DOLLAR}|\\)+" for quote in "'\""}
_WORD_TEXT = {
    "": rf"(?:\\[\"']|[^ '\\\"$()]|(?<=\\)[()]|{_DOLLAR}|\\)+",
    "'": rf"(?:\\'|[^ '\\$()]|(?<=\\)[()]|{_DOLLAR}|\\)+",
    '"': rf"(?:\\\"|[^ \"\\$()]|(?<=\\)[()]|{_DOLLAR}|\\)+",
}


@dataclass(frozen=True, slots=True)
class Text:
    """Literal text without escapes; `position` is its offset in the source text."""

    text: str
    position: int


@dataclass(frozen=True, slots=True)
class SubstitutionCall:
    """`$(name word word)`; a word is a sequence of parts, and may be empty."""

    name: str
    words: tuple[tuple[Part, ...], ...]
    position: int


Part = Text | SubstitutionCall


class GrammarError(ValueError):
    """Invalid syntax; `position` counts from 0, `at_end`: more text was expected."""

    def __init__(self, message: str, *, position: int, at_end: bool) -> None:
        super().__init__(message)
        self.position = position
        self.at_end = at_end


def parse_template(source: str) -> tuple[Part, ...]:
    """The parts of an attribute's value; GrammarError if it is invalid. Never empty."""
    if "$" not in source:
        return (Text(unescape(source), 0),)
    return _SubstitutionReader(source).template()


def unescape(text: str) -> str:
    """Remove one level of backslashes."""
    return re.sub(_ESCAPED, r"\1", text) if "\\" in text else text


class _SubstitutionReader:
    """One pass over a source text, left to right, without backtracking."""

    def __init__(self, source: str) -> None:
        self._source = source
        self._at = 0
        self._depth = 0

    def template(self) -> tuple[Part, ...]:
        parts: list[Part] = []
        while self._at < len(self._source):
            parts.append(self._call_or_text(_TEMPLATE_TEXT, ""))
        return tuple(parts)

    def _call_or_text(self, pattern: str, quote: str) -> Part:
        found = self._match(pattern)
        if found is None:
            return self._call(quote)
        start, self._at = self._at, found.end()
        return Text(unescape(found.group()), start)

    def _call(self, quote: str) -> SubstitutionCall:
        start = self._at
        self._take("$(", "a substitution")
        self._depth += 1
        if self._depth > MAX_DEPTH:
            self._fail(f"substitutions are nested more than {MAX_DEPTH} deep")
        name = self._match(_NAME)
        if name is None:
            self._fail("expected the name of a substitution after '$('")
        self._at = name.end()
        words = self._words(quote)
        self._take(")", f"')' to close '$({name.group()}'")
        self._depth -= 1
        return SubstitutionCall(name.group(), words, start)

    def _words(self, quote: str) -> tuple[tuple[Part, ...], ...]:
        words = []
        while self._next_is(" "):
            self._at += 1
            words.append(self._word(quote))
        return tuple(words)

    def _word(self, quote: str) -> tuple[Part, ...]:
        if not quote and self._at < len(self._source) and self._source[self._at] in "'\"":
            return self._quoted_word(self._source[self._at])
        parts: list[Part] = []
        text = _WORD_TEXT[quote]
        while self._match(text) or self._next_is("$("):
            parts.append(self._call_or_text(text, quote))
        if not parts:
            self._fail("expected a word (words are separated by exactly one space)")
        return tuple(parts)

    def _quoted_word(self, quote: str) -> tuple[Part, ...]:
        self._at += 1
        parts: list[Part] = []
        text = _QUOTED_TEXT[quote]
        while self._match(text) or self._next_is("$("):
            parts.append(self._call_or_text(text, quote))
        self._take(quote, f"a closing {quote}")
        return tuple(parts)

    def _match(self, pattern: str) -> re.Match[str] | None:
        return re.compile(pattern).match(self._source, self._at)

    def _next_is(self, token: str) -> bool:
        return self._source.startswith(token, self._at)

    def _take(self, token: str, expected: str) -> None:
        if not self._next_is(token):
            self._fail(f"expected {expected}")
        self._at += len(token)

    def _fail(self, message: str) -> NoReturn:
        at_end = self._at >= len(self._source)
        found = "the text ends here" if at_end else f"found {self._source[self._at]!r}"
        raise GrammarError(f"{message}, {found}", position=self._at, at_end=at_end)
