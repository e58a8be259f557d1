"""Sentences for errors of the YAML parser: what is wrong with the line, and what to write."""

from __future__ import annotations

import re

import yaml

from launcher.language.frontends.entity import SourceText
from launcher.language.frontends.errors import FrontendError, shown

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

_QUOTES = "put the value in quotes"
_PLAIN_KEY = re.compile(r"^\s*(?:- +)*[\w-]+\s*:\s*\S")


def located(problem: yaml.MarkedYAMLError, source: SourceText) -> FrontendError:
    """The error with its line, in the words of launch files instead of the parser's."""
    mark = problem.problem_mark or problem.context_mark
    if mark is None:
        return FrontendError(
            problem.problem or problem.context or "invalid YAML", ros_type=type(problem).__name__
        )
    message, hint, mark = _sentence(problem, mark, source)
    place = source.place(mark.line + 1, mark.column + 1)
    return FrontendError(message, place=place, hint=hint, ros_type=type(problem).__name__)


_Sentence = tuple[str, "str | None", yaml.Mark]


def _sentence(problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText) -> _Sentence:
    text = problem.problem or ""
    line = _line(source, mark.line)
    if line.lstrip(" ").startswith("\t"):
        return "a tab at the beginning of a line", "indent with spaces", mark
    for pattern, sentence in _SENTENCES:
        found = re.match(pattern, text)
        if found:
            return sentence(problem, mark, source, found)
    return shown(text or problem.context or "invalid YAML"), None, mark


def _line(source: SourceText, number: int) -> str:
    return source.lines[number] if 0 <= number < len(source.lines) else ""


def _block(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    """A block ends where it should not: by its indentation, or by text behind a value."""
    line = _line(source, mark.line)
    if line[: mark.column].strip(" -"):
        return "there is text behind the end of a value", _QUOTES, mark
    number, column = _neighbour(source, mark)
    return (
        f"this line is indented by {_spaces(mark.column)}, line {number} by {column}",
        f"begin it with {_spaces(column)}, like line {number}",
        mark,
    )


def _neighbour(source: SourceText, mark: yaml.Mark) -> tuple[int, int]:
    """(number, indentation) of the nearest line above; for an item of a list, the nearest item."""
    is_item = _line(source, mark.line)[mark.column :].startswith("-")
    for number in range(mark.line - 1, -1, -1):
        line = _line(source, number)
        text = line.strip()
        if text and not text.startswith("#") and (text.startswith("-") or not is_item):
            return number + 1, len(line) - len(line.lstrip()) if is_item else _indentation(line)
    return 1, 0


def _spaces(number: int) -> str:
    return "no space" if number == 0 else f"{number} space{'s' if number > 1 else ''}"


def _document(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    hint = "indent it by the same number of spaces as the line above"
    return "this line belongs to no block above", hint, mark


def _no_colon(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    begin = problem.context_mark or mark
    words = _line(source, begin.line)[begin.column :].split()
    hint = "write KEY: VALUE"
    if words and re.fullmatch(r"[\w-]+", words[0]):
        hint = shown(f"write '{' '.join([f'{words[0]}:', *words[1:]])}'")
    return "this line has no ':' after its key", hint, begin


def _colon_in_value(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    line = _line(source, mark.line)
    if _PLAIN_KEY.match(line[: mark.column]):
        return "the value holds a ':', as if it were a key", _QUOTES, mark
    above = next((n for n in range(mark.line - 1, -1, -1) if _line(source, n).strip()), mark.line)
    if ":" not in _line(source, above):
        hint = f"write '{_line(source, above).strip()}:' in line {above + 1}"
        return "a key in a value: the line above has no ':' at its end", shown(hint), mark
    hint = f"indent it like line {above + 1}: with {_spaces(_indentation(_line(source, above)))}"
    return "this line is indented further than the key above, which has a value", hint, mark


def _indentation(line: str) -> int:
    """Where the key of a line begins, behind the `- ` of an item."""
    found = re.match(r"[ ]*(?:- +)*", line)
    return found.end() if found else 0


def _quote(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    begin = problem.context_mark or mark
    if "quoted" not in (problem.context or ""):
        return "the file ends in the middle of a value", None, begin
    return "the quote that begins here has no end", "add the closing quote", begin


def _flow(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    begin = problem.context_mark or mark
    opening = "{" if found[1] == "}" else "["
    return f"the '{opening}' that begins here has no '{found[1]}'", f"add '{found[1]}'", begin


def _first_character(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    if found[1] == "\\t":
        return "a tab where YAML allows only spaces", "write spaces", mark
    return f"a value cannot begin with '{found[1]}'", _QUOTES, mark


def _alias(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    message = f"'*{found[1]}' stands for an anchor, and there is no '&{found[1]}' above"
    return message, f"{_QUOTES} if it is a text", mark


def _tag(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    return f"a value that begins with '!' is a YAML tag, and '{found[1]}' is none", _QUOTES, mark


def _list_in_line(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    hint = "begin the list in the next line, indented further than its key"
    return "a list cannot begin in the line of its key", hint, mark


def _escape(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    hint = "write two backslashes, or put the value in single quotes"
    return f"'\\{found[1]}' means nothing in double quotes", hint, mark


def _documents(
    problem: yaml.MarkedYAMLError, mark: yaml.Mark, source: SourceText, found: re.Match[str]
) -> _Sentence:
    return "a second document begins here", "a launch file is one document: remove '---'", mark


_SENTENCES: tuple[tuple[str, Callable[..., _Sentence]], ...] = (
    (r"expected <block end>", _block),
    (r"expected '<document start>'", _document),
    (r"could not find expected ':'", _no_colon),
    (r"mapping values are not allowed", _colon_in_value),
    (r"found unexpected end of stream", _quote),
    (r"found unexpected document separator", _quote),
    (r"expected ',' or '(.)'", _flow),
    (r"found character '(\\t|.)' that cannot start", _first_character),
    (r"found undefined alias '(.*)'", _alias),
    (r"could not determine a constructor for the tag '(.*)'", _tag),
    (r"(block )?sequence entries are not allowed", _list_in_line),
    (r"found unknown escape character '(.*)'", _escape),
    (r"but found another document", _documents),
)
