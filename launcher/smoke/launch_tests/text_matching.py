"""Finds expected text or lines in an output; a finder returns (start, end), or None."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any

_ANSI = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(?:\x07|\x1b\\)|[@-Z\\^_])")
FILTERED_PREFIXES = ("pid", "rc")

Span = tuple[int, int]
Finder = Callable[..., "Span | None"]  # of (actual, start)


def without_escapes(text: str) -> str:
    return _ANSI.sub("", text)


def normalize_lineseps(lines: str) -> str:
    r"""The text with `\n` for every end of a line: a terminal writes `\r\n`."""
    return lines.replace(os.linesep, "\n").replace("\r\n", "\n")


def build_text_match(expected_text: Any, *, strict: bool = False) -> Finder:
    """A finder in a text, of a text, a compiled pattern, or a sequence of these.

    `strict`: a text is all that there is from `start`; others begin there.
    """
    if isinstance(expected_text, str):
        return lambda actual, start=0: _text_span(
            expected_text, normalize_lineseps(actual), start, strict
        )
    if hasattr(expected_text, "search") and hasattr(expected_text, "match"):
        search = expected_text.match if strict else expected_text.search

        def find(actual: str, start: int = 0) -> Span | None:
            found = search(normalize_lineseps(actual), start)
            return None if found is None else found.span()

        return find
    if isinstance(expected_text, Iterable):
        return _sequence([build_text_match(one) for one in expected_text], strict)
    raise ValueError("Unknown format for expected text")


def _text_span(expected: str, actual: str, start: int, strict: bool) -> Span | None:
    if strict:
        return (start, start + len(expected)) if actual[start:] == expected else None
    found = actual.find(expected, start)
    return None if found < 0 else (found, found + len(expected))


def build_line_match(expected_lines: Any, *, strict: bool = False) -> Finder:
    """A finder in a list of lines, of a part of a line, a pattern, or a sequence of these.

    `strict`: all lines from `start` fit a text or a pattern; a sequence has nothing in between.
    """
    if isinstance(expected_lines, str):
        if strict:
            return _lines(lambda line: line == expected_lines, strict)
        return _lines(lambda line: expected_lines in line, strict)
    if hasattr(expected_lines, "match"):
        return _lines(lambda line: expected_lines.match(line) is not None, strict)
    if isinstance(expected_lines, Iterable):
        return _sequence([build_line_match(one) for one in expected_lines], strict)
    raise ValueError("Unknown format for expected lines")


def _lines(fits: Callable[[str], bool], strict: bool) -> Finder:
    def find(actual: Sequence[str], start: int = 0) -> Span | None:
        if strict:
            return (start, len(actual)) if all(map(fits, actual[start:])) else None
        for index in range(start, len(actual)):
            if fits(actual[index]):
                return index, index + 1
        return None

    return find


def _sequence(finders: list[Finder], strict: bool) -> Finder:
    def find(actual: Any, start: int = 0) -> Span | None:
        spans: list[Span] = []
        position = start
        for finder in finders:
            span = finder(actual, position)
            if span is None or (strict and span[0] != position):
                return None
            spans.append(span)
            position = span[1]
        return (spans[0][0] if spans else start), position

    return find


def expect_output(
    text: str | None = None,
    *,
    lines: Sequence[str] | None = None,
    expected_text: Any = None,
    expected_lines: Any = None,
    strip_ansi_escape_sequences: bool = True,
    strict: bool = False,
) -> bool:
    """Whether the output, a text or its lines, has what is expected, a text or lines."""
    if (text is None) == (lines is None):
        raise ValueError("Either lines or text, but not both, must be specified")
    if (expected_text is None) == (expected_lines is None):
        raise ValueError("Either expected lines or text, but not both, must be specified")
    whole = "\n".join(lines or ()) if text is None else text
    if strip_ansi_escape_sequences:
        whole = without_escapes(whole)
    if expected_text is not None:
        return build_text_match(expected_text, strict=strict)(whole) is not None
    return build_line_match(expected_lines, strict=strict)(whole.splitlines()) is not None


def expected_output_from_file(path: str, encoding: str | None = None) -> list[Any]:
    """The lines of `path`.txt, or else the patterns of `path`.regex. RuntimeError without both."""
    for extension, made in ((".txt", str), (".regex", re.compile)):
        if os.path.isfile(path + extension):
            with open(path + extension, encoding=encoding) as file:
                return [made(line) for line in file.read().splitlines()]
    raise RuntimeError(f"could not find output check file: {path}")


def get_default_filtered_prefixes() -> list[str]:
    return list(FILTERED_PREFIXES)


def get_default_filtered_patterns() -> list[str]:
    return []


def basic_output_filter(
    filtered_prefixes: Iterable[str] | None = None,
    filtered_patterns: Iterable[str] | None = None,
) -> Callable[[str], str]:
    """A function that leaves out the lines that begin with a prefix or match a pattern."""
    prefixes = tuple(FILTERED_PREFIXES if filtered_prefixes is None else filtered_prefixes)
    patterns = [re.compile(one) for one in filtered_patterns or ()]

    def filtered(output: str) -> str:
        return "".join(
            line
            for line in output.splitlines(keepends=True)
            if not line.startswith(prefixes) and not any(one.match(line) for one in patterns)
        )

    return filtered
