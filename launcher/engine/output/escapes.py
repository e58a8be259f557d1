"""Control characters of a process's output that must not reach a terminal, besides cursor moves.

Files and pipes get these bytes as they are: only a terminal obeys them.
"""

from __future__ import annotations

import re

# ENQ is answered on our standard input, BEL rings, DC1 to DC4 are flow control and printers, CAN
# and SUB break off what a terminal is reading, and DEL is taken for a character by some.
_CONTROLS = b"\x05\x07\x11\x12\x13\x14\x18\x1a\x7f"
_HIDING = (b"5", b"6", b"8")  # blinking, blinking fast, hidden
_COLOURS = (b"38", b"48", b"58")  # of letters, of what is behind them, of lines below them
_COLOUR_WORDS = {b"5": 2, b"2": 4}  # `38;5;N` and `38;2;R;G;B`: what follows 38 are no attributes
# A sequence with such a word; not the commonest one that has, a colour of the 256.
_SUSPECT = rb"\x1b\[(?![34]8;5;\d+m)((?:[0-9;:]*[;:])?0*[568](?:[;:][0-9;:]*)?)m"


def without_controls(text: bytes) -> bytes:
    """Lines that `for_screen` has cleaned, without what controls a terminal in other ways.

    Colours, bold, italics, underlining and the like stay, and so do bytes that are no UTF-8
    outside of 0x80 to 0x9F, where terminals with 8-bit controls see escape sequences.
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
    """The sequence without what hides its text; nothing if that was all."""
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
    """The text without a character of UTF-8 at its end whose rest is still to come."""
    for back in range(1, min(4, len(text) + 1)):
        byte = text[-back]
        if byte & 0xC0 == 0x80:
            continue
        size = 2 if byte < 0xE0 else 3 if byte < 0xF0 else 4
        return text[:-back] if 0xC2 <= byte <= 0xF4 and size > back else text
    return text
