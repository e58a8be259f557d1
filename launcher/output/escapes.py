"""Removes control characters from output that goes to a terminal.

Cursor movements are removed before, by `lines.for_terminal`. Files and pipes get these bytes.
"""

from __future__ import annotations

import re

# ENQ makes the terminal write to our standard input, BEL rings, DC1 to DC4 control flow and
# printers, CAN and SUB abort an escape sequence, and some terminals print DEL.
_CONTROLS = b"\x05\x07\x11\x12\x13\x14\x18\x1a\x7f"
_HIDING = (b"5", b"6", b"8")  # blinking, blinking fast, hidden
_COLOURS = (b"38", b"48", b"58")  # of letters, of what is behind them, of lines below them
_COLOUR_WORDS = {b"5": 2, b"2": 4}  # `38;5;N` and `38;2;R;G;B`: numbers after 38 are not attributes
# A sequence with a hiding attribute, or a number like one; not a single colour of the 256.
_SUSPECT = rb"\x1b\[(?![34]8;5;\d+m)((?:[0-9;:]*[;:])?0*[568](?:[;:][0-9;:]*)?)m"


def without_controls(text: bytes) -> bytes:
    """Lines cleaned by `for_terminal`, without all other control characters and hidden text.

    Colours, bold, italics and underlining stay. Of bytes that are not UTF-8, 0x80 to 0x9F are
    removed: terminals with 8-bit controls read them as escape sequences.
    """
    if not text.isascii():
        text = _without_8_bit_controls(text)
    text = text.translate(None, _CONTROLS)
    if 0x1B not in text:
        return text
    return re.sub(_SUSPECT, _attributes, text)


def _without_8_bit_controls(text: bytes) -> bytes:
    try:
        decoded = text.decode()
    except UnicodeDecodeError:
        decoded = text.decode(errors="surrogateescape")
    else:
        if 0xC2 not in text:
            return text  # all such bytes are parts of characters
    kept = re.sub("[\x80-\x9f\udc80-\udc9f]", "", decoded)
    return kept.encode(errors="surrogateescape")


def _attributes(found: re.Match[bytes]) -> bytes:
    """The sequence without hiding attributes; empty if it has no others."""
    words = found[1].split(b";")
    kept: list[bytes] = []
    at = 0
    while at < len(words):
        size = 1
        if _number(words[at]) in _COLOURS and at + 1 < len(words):
            size += _COLOUR_WORDS.get(_number(words[at + 1]), 0)
        if _number(words[at].partition(b":")[0]) not in _HIDING:
            kept += words[at : at + size]
        at += size
    return b"\x1b[" + b";".join(kept) + b"m" if kept else b""


def _number(word: bytes) -> bytes:
    return word.lstrip(b"0")


def whole_characters(text: bytes) -> bytes:
    """The text without an incomplete UTF-8 character at its end."""
    for back in range(1, min(4, len(text) + 1)):
        byte = text[-back]
        if byte & 0xC0 == 0x80:
            continue
        size = 2 if byte < 0xE0 else 3 if byte < 0xF0 else 4
        return text[:-back] if 0xC2 <= byte <= 0xF4 and size > back else text
    return text
