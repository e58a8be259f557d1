"""Text for users: suggestions for misspelt words, counts, escaping of control characters."""

from __future__ import annotations

import os
import re

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Sequence

# Least similarity: `kil` and `kill` have 0.86, `bogus` and `logs` 0.67.
_CUTOFF, _CUTOFF_SHORT, _SHORT = 0.6, 0.7, 6


def suggest(word: str, known: Iterable[str], likeness: float | None = None) -> str | None:
    """The most similar known word; None if none is similar, or several equally.

    Of several the one with the same letters is preferred: `plan` for `plna`, and not `play`.
    """
    import difflib  # only mistakes need it

    words = list(dict.fromkeys(known))
    cutoff = likeness or (_CUTOFF_SHORT if len(word) < _SHORT else _CUTOFF)
    similar = difflib.get_close_matches(word, words, n=2, cutoff=cutoff)
    if len({difflib.SequenceMatcher(None, one, word).ratio() for one in similar}) < len(similar):
        similar = []
    if similar:
        return similar[0]
    anagrams = [one for one in words if sorted(one) == sorted(word)]  # `cta` for `cat`
    return anagrams[0] if len(anagrams) == 1 else None


def launch_stem(word: str) -> str:
    """`first` for `first.launch`, `first.py` and `first_launch.xml`, to look for similar files."""
    return re.sub(r"([._]launch)?(\.(py|xml|ya?ml))?$", "", word, count=1)


def did_you_mean(word: str, known: Iterable[str]) -> str | None:
    """`did you mean 'dispatcher'?`; None if no known word is similar."""
    similar = suggest(word, known)
    return similar and f"did you mean '{similar}'?"


def one_of(words: Iterable[str]) -> str:
    """`'a'`, `'a' or 'b'`, `'a', 'b' or 'c'`."""
    *before, last = (f"'{word}'" for word in words)
    return f"{', '.join(before)} or {last}" if before else last


def several(names: Iterable[str], most: int = 4) -> str:
    """`a, b and 3 more`."""
    known = list(names)
    more = len(known) - most
    return ", ".join(known[:most]) + (f" and {more} more" if more > 0 else "")


def shown_path(path: str) -> str:
    """The path without `..` and `.`, for users; unchanged where links make that another file."""
    normal = os.path.normpath(path)
    if normal == path:
        return path
    return normal if os.path.realpath(normal) == os.path.realpath(path) else path


def count(number: int, noun: str) -> str:
    """`1 process`, `2 processes`, `3 nodes`."""
    plural = f"{noun}es" if noun.endswith("s") else f"{noun}s"
    return f"{number} {noun if number == 1 else plural}"


def escape(text: str, *, keep: str = "\n\t") -> str:
    """The text with unprintable characters as backslash escapes, except those in `keep`."""
    if text.isprintable():
        return text
    return "".join(
        char if char.isprintable() or char in keep else char.encode("unicode_escape").decode()
        for char in text
    )


def escape_controls(text: str) -> str:
    """The text with control characters as `\\x1b`, except newlines and tabs.

    Unlike `escape` it keeps all other characters, as messages of nodes need.
    """
    return re.sub(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]", lambda found: f"\\x{ord(found[0]):02x}", text)


def drop_controls(text: str) -> str:
    """The text without control characters, except newlines, tabs and sequences that set colours."""
    return re.sub(r"\x1b(?!\[[0-9;:]*m)|[\x00-\x08\x0b-\x1a\x1c-\x1f\x7f-\x9f]", "", text)


def error_text(error: BaseException) -> str:
    """What an exception says, or its class if it says nothing, as that of `assert` may."""
    return str(error) or type(error).__name__


def typed_error(error: BaseException) -> str:
    """`KeyError: 'a'`, or the class alone if the exception says nothing."""
    name, text = type(error).__name__, str(error)
    return f"{name}: {text}" if text else name


def how_it_ended(returncode: int) -> str:
    """`exit code 1`, or `signal 9` for the negative return code of a process that it ended."""
    return f"exit code {returncode}" if returncode >= 0 else f"signal {-returncode}"


def aligned(rows: Sequence[Sequence[str]], right: Collection[int] = ()) -> list[str]:
    """The rows as lines of a table; the columns `right` are aligned to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            text.rjust(width) if column in right else text.ljust(width)
            for column, (text, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
