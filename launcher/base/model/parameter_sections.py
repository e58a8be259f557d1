"""Which parameters of a parameter file are for a node, by the rules of rcl.

A tree is the content of a file: data, or the nodes of `yaml.compose`, which have lines.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

from launcher.base.model.record import Record

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

PARAMETERS = "ros__parameters"
_WILD = {"**": r"(/[^/]+)*", "*": r"/[^/]+"}


class Section(Record):
    """The tree of parameters below the keys that `selector` joins: `/ns/node`, `/*/node`, `/**`."""

    selector: str
    parameters: object

    @property
    def is_exact(self) -> bool:
        """Whether it is for one node, without wildcards."""
        return "*" not in self.selector

    def is_for(self, node: str) -> bool:
        """Whether it is for the node with this full name."""
        tokens = (token for token in self.selector.split("/") if token)
        pattern = "".join(_WILD.get(token, f"/{re.escape(token)}") for token in tokens)
        return re.fullmatch(pattern, node) is not None


def sections(tree: object) -> Iterator[Section]:
    """The sections of a file, in order: the last one that has a parameter wins."""
    return _sections(tree, "")


def _sections(tree: object, selector: str) -> Iterator[Section]:
    for name, _, value in _items(tree):
        if name == PARAMETERS and selector:
            yield Section(selector, value)
        else:
            yield from _sections(value, f"{selector}/{name.strip('/')}".rstrip("/"))


def parameters(tree: object, prefix: str = "") -> Iterator[tuple[str, Any, Any]]:
    """(name, key, value) of the parameters of a section; levels become dots in names."""
    for name, key, value in _items(tree):
        if _is_mapping(value):
            yield from parameters(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", key, value


def parameters_for(node: str, known: Iterable[Section]) -> Iterator[tuple[str, Any, Any]]:
    """Like `parameters`, of the sections for a node; what is for it alone comes last.

    So do a load request and `param load` of ROS 2. For the file of a process, rcl keeps the order
    of the file.
    """
    own = [section for section in known if section.is_for(node)]
    for section in sorted(own, key=lambda one: one.is_exact):
        yield from parameters(section.parameters)


def _is_mapping(tree: object) -> bool:
    return isinstance(tree, Mapping) or getattr(tree, "id", None) == "mapping"


def _items(tree: Any) -> Iterator[tuple[str, Any, Any]]:
    """(name, key, value) of a mapping; nothing else has any."""
    if isinstance(tree, Mapping):
        yield from ((str(key), key, value) for key, value in tree.items())
    elif _is_mapping(tree):
        yield from ((str(key.value), key, value) for key, value in tree.value)
