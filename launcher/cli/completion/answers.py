"""What a script gets: one completion a line; the rules of quoting are those of the shell."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from launcher.base.errors import LauncherError
from launcher.cli.completion.grammar import Candidate, candidates

_SPECIAL = re.compile(r"([^\w@%+:,./=\-])")
_OPEN_ENDS = (":=", "=", "/")  # more of the word follows


def answer(shell: str, words: Sequence[str]) -> str:
    """The lines for `words`: for bash its line and COMP_WORDBREAKS, else those behind the program.

    Nothing, if the launch file or the run cannot be read: the command itself will say why.
    """
    try:
        if shell == "bash":
            lines = list(bash_lines(*words[:2]))
        else:
            lines = [f"{value}\t{text}".rstrip("\t") for value, text in found(words)]
    except (LauncherError, OSError):
        return ""
    return "".join(f"{line}\n" for line in lines)


def found(words: Sequence[str]) -> list[Candidate]:
    """The candidates that begin with the last word, each once; texts in one line."""
    unique: dict[str, str] = {}
    for value, text in candidates(words):
        if value.startswith(words[-1]) and "\n" not in value:
            unique.setdefault(value, " ".join(text.split()))
    return list(unique.items())


def bash_lines(line: str, breaks: str = "") -> Iterable[str]:
    """Completions for a command line up to the cursor.

    readline replaces only what follows the last of its `breaks`, unless the word is quoted.
    """
    words, raw, quote = split(line)
    start = (
        0 if quote else max((raw.rfind(each) for each in breaks if each in ":="), default=-1) + 1
    )
    kept = len(split(raw[:start])[0][-1]) if start else 0
    for value, _ in found(words[1:] or [""]):
        if quote:
            yield value[kept:]
        else:
            end = "" if value.endswith(_OPEN_ENDS) else " "
            yield _SPECIAL.sub(r"\\\1", value[kept:]) + end


def split(line: str) -> tuple[list[str], str, str]:
    """(the words of a line, the last one as it was typed, the quote that is still open in it)."""
    words, raw, quote = [""], "", ""
    pieces = re.finditer(r"\\(.)|([\"'])|(\s+)|.", line, re.S)
    for piece in pieces:
        escaped, mark, space = piece.group(1, 2, 3)
        raw += piece[0]
        if space is not None and not quote:
            words.append("")
            raw = ""
        elif mark is not None and mark == quote:
            quote = ""
        elif mark is not None and not quote:
            quote = mark
        elif escaped is not None and quote == "'":
            words[-1] += piece[0]
        else:
            words[-1] += piece[0] if escaped is None else escaped
    return words, raw, quote
