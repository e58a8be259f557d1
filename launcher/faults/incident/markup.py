"""HTML and SVG out of texts that others have written: everything but `Markup` is escaped."""

from __future__ import annotations

import html
from collections.abc import Iterable

from launcher.base.text import escape
from launcher.output.lines import for_pipe, without_colour

_VOID = frozenset({"br", "hr", "input", "meta", "path", "rect", "line", "polygon", "ellipse"})
_ENDLESS = frozenset({"input", "meta", "br", "hr"})  # of HTML, which has no `/>`


class Markup(str):
    """Text that is HTML already; `tag`, `join` and `text` make it."""

    __slots__ = ()


EMPTY = Markup("")


def plain(text: str, *, keep: str = "") -> str:
    """The text without colours and movements of the cursor, other invisible characters as escapes.

    So bidirectional controls cannot reorder a line, and halves of surrogates stay visible. `keep`
    has characters that stay, such as newlines.
    """
    if text.isprintable():
        return text
    data = text.encode("utf-8", "surrogatepass")
    lines = b"\n".join(without_colour(for_pipe(line)) for line in data.split(b"\n"))
    return escape(lines.decode("utf-8", "surrogatepass"), keep=keep)


def text(value: object, *, keep: str = "") -> Markup:
    """The text of a value, escaped; `Markup` as it is."""
    if isinstance(value, Markup):
        return value
    return Markup(html.escape(plain(str(value), keep=keep)))


def join(parts: Iterable[object], between: str = "") -> Markup:
    """All parts, escaped as `text` does; `between` is escaped, too."""
    return Markup(text(between).join(text(part) for part in parts))


def tag(name: str, /, *children: object, **attributes: object) -> Markup:
    """An element. A name of an attribute may end in `_` (`class_`), and `_` stands for `-`.

    Attributes that are None or False are left out; True is one without a value.
    """
    words = [name]
    for key, value in attributes.items():
        spelled = key.rstrip("_").replace("_", "-")
        if value is True:
            words.append(spelled)
        elif value is not None and value is not False:
            words.append(f'{spelled}="{text(value)}"')
    start = " ".join(words)
    if name in _VOID and not children:
        return Markup(f"<{start}>" if name in _ENDLESS else f"<{start}/>")
    return Markup(f"<{start}>{join(children)}</{name}>")


def when(condition: object, part: Markup) -> Markup:
    """The part, or nothing."""
    return part if condition else EMPTY


def section(name: str, title: str, *children: object) -> Markup:
    """A section of the page with its heading; nothing if it is empty."""
    inside = join(children)
    if not inside:
        return EMPTY
    head = tag("h2", title, id=f"{name}-title")
    return tag("section", head, inside, id=name, aria_labelledby=f"{name}-title")


def details(summary: object, *children: object, is_open: bool = False) -> Markup:
    return tag("details", tag("summary", summary), *children, open=is_open)


def facts(rows: Iterable[tuple[str, object]], class_: str = "facts") -> Markup:
    """A list of names and values; rows without a value are left out."""
    shown = [
        tag("div", tag("dt", name), tag("dd", value))
        for name, value in rows
        if value not in (None, "", EMPTY)
    ]
    return tag("dl", *shown, class_=class_) if shown else EMPTY
