"""Shell words: any word as a person can paste it into a shell."""

from __future__ import annotations

import shlex

_NAMED = {"\n": r"\n", "\t": r"\t", "\r": r"\r", "\x1b": r"\e", "\\": r"\\", "'": r"\'"}


def shell_word(word: str) -> str:
    """The word in quotes where it needs them; `$'...'` with escapes if it cannot be printed.

    What stands for a byte that is no UTF-8 (as in file names of Python) becomes that byte again.
    """
    if word.isprintable():
        return shlex.quote(word)
    return "$'" + "".join(map(_escaped, word)) + "'"


def _escaped(char: str) -> str:
    if char in _NAMED:
        return _NAMED[char]
    if char.isprintable():
        return char
    # Bytes in octal: of these a shell reads three digits at most, whatever follows.
    try:
        data = char.encode(errors="surrogateescape")
    except UnicodeEncodeError:
        return char  # no program can be given it
    return "".join(f"\\{byte:03o}" for byte in data)
