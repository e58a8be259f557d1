"""Branches: a tree of texts, drawn with lines, in colour where the reader has a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

# What a text is, and how it looks on a terminal (SGR codes).
STYLES = {
    "plain": "",
    "process": "1;36",
    "scope": "1",
    "event": "33",
    "skipped": "2",
    "value": "32",
    "error": "31",
    "command": "",
    "aside": "2",
}


class Branch:
    """One entry: a head in its style, a dim remark behind it, lines below it, further entries."""

    __slots__ = ("aside", "children", "head", "lines", "style")

    def __init__(
        self,
        head: str,
        *,
        style: str = "plain",
        aside: str = "",
        lines: Iterable[tuple[str, str]] = (),
        children: Iterable[Branch] = (),
    ) -> None:
        self.head = head
        self.style = style
        self.aside = aside
        self.lines = list(lines)  # (style, text)
        self.children = list(children)


def draw(root: Branch, *, colour: bool) -> str:
    """The tree as text."""
    return "\n".join(_lines(root, "", "", colour=colour))


def _lines(branch: Branch, first: str, rest: str, *, colour: bool) -> Iterator[str]:
    aside = f"  {_paint(branch.aside, 'aside', colour)}" if branch.aside else ""
    yield first + _paint(branch.head, branch.style, colour) + aside
    hanging = rest + ("│   " if branch.children else "    ")
    for style, text in branch.lines:
        yield hanging + _paint(text, style, colour)
    for child in branch.children:
        last = child is branch.children[-1]
        tip, below = ("└── ", "    ") if last else ("├── ", "│   ")
        yield from _lines(child, rest + tip, rest + below, colour=colour)


def _paint(text: str, style: str, colour: bool) -> str:
    text = visible(text)
    code = STYLES[style]
    return f"\x1b[{code}m{text}\x1b[0m" if colour and code else text


def visible(text: str) -> str:
    """The text on one line, with control characters as escapes."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
