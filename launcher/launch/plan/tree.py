"""Draws trees with box-drawing characters and colours."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from launcher.base.text import escape

# Parameters of SGR sequences.
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
    """An entry: a styled head with a dim remark, lines as (style, text), and entries below.

    For `outline`: `place` is `file:line`, `process` the index of a process in the plan.
    """

    __slots__ = ("aside", "children", "head", "lines", "place", "process", "style")

    def __init__(
        self,
        head: str,
        *,
        style: str = "plain",
        aside: str = "",
        lines: Iterable[tuple[str, str]] = (),
        children: Iterable[Branch] = (),
        place: str = "",
        process: int | None = None,
    ) -> None:
        self.head = head
        self.style = style
        self.aside = aside
        self.place = place
        self.process = process
        self.lines = list(lines)
        self.children = list(children)


def draw(root: Branch, *, colour: bool) -> str:
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
    text = escape(text, keep="")
    code = STYLES[style]
    return f"\x1b[{code}m{text}\x1b[0m" if colour and code else text
