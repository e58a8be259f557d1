"""Nodes: what the graph says about them, in the texts of `ros2 node`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from launcher.graph.errors import VerbError, did_you_mean
from launcher.graph.observer import Observer
from launcher.graph.snapshot import is_hidden

NamesAndTypes = list[tuple[str, list[str]]]

SHARED_NAME = (
    "WARNING: Be aware that there are nodes in the graph that share an exact name, "
    "which can have unintended side effects."
)


def visible_names(names: list[str], *, hidden: bool) -> list[str]:
    """The names that `node list` prints."""
    return [name for name in names if hidden or not is_hidden(name)]


def sections(observer: Observer, full: str, *, hidden: bool) -> dict[str, NamesAndTypes]:
    """Title -> what one node has of it, sorted; VerbError if there is no such node."""
    known = observer.node_names()
    if full not in known:
        hint = did_you_mean(full, visible_names(known, hidden=False))
        raise VerbError(f"Unable to find node '{full}'", hint=hint)
    namespace, _, name = full.rpartition("/")
    found = _ask(observer.node, name, namespace or "/")
    return {
        title: [(n, list(types)) for n, types in sorted(entries) if hidden or not is_hidden(n)]
        for title, entries in found.items()
    }


def _ask(node: Any, name: str, namespace: str) -> dict[str, NamesAndTypes]:
    from rclpy.action import (
        get_action_client_names_and_types_by_node,
        get_action_server_names_and_types_by_node,
    )

    return {
        "Subscribers": node.get_subscriber_names_and_types_by_node(name, namespace),
        "Publishers": node.get_publisher_names_and_types_by_node(name, namespace),
        "Service Servers": node.get_service_names_and_types_by_node(name, namespace),
        "Service Clients": node.get_client_names_and_types_by_node(name, namespace),
        "Action Servers": get_action_server_names_and_types_by_node(node, name, namespace),
        "Action Clients": get_action_client_names_and_types_by_node(node, name, namespace),
    }


def info_lines(full: str, found: dict[str, NamesAndTypes]) -> Iterator[str]:
    """The lines of `node info`; a section without entries has one empty line."""
    yield full
    for title, entries in found.items():
        yield f"  {title}:"
        yield "\n".join(f"    {name}: {', '.join(types)}" for name, types in entries)
