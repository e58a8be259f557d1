"""Nodes: what the graph says about them, in the texts of `ros2 node`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from launcher.graph.errors import VerbError, did_you_mean
from launcher.graph.look import Look, NamesAndTypes
from launcher.graph.snapshot import is_hidden

SHARED_NAME = (
    "WARNING: Be aware that there are nodes in the graph that share an exact name, "
    "which can have unintended side effects."
)


def visible_names(names: Iterable[str], *, hidden: bool) -> list[str]:
    """The names that `node list` prints."""
    return [name for name in names if hidden or not is_hidden(name)]


def sections(look: Look, full: str, *, hidden: bool) -> dict[str, NamesAndTypes]:
    """Title -> what one node has of it, sorted; VerbError if there is no such node."""
    if full not in look.nodes:
        hint = did_you_mean(full, visible_names(look.nodes, hidden=False))
        raise VerbError(f"Unable to find node '{full}'", hint=hint)
    return {
        title: [(name, types) for name, types in entries if hidden or not is_hidden(name)]
        for title, entries in look.of_node(full).items()
    }


def info_lines(full: str, found: dict[str, NamesAndTypes]) -> Iterator[str]:
    """The lines of `node info`; a section without entries has one empty line."""
    yield full
    for title, entries in found.items():
        yield f"  {title}:"
        yield "\n".join(f"    {name}: {', '.join(types)}" for name, types in entries)
