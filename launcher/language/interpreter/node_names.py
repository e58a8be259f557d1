"""Warns of nodes that have the same full name."""

from __future__ import annotations

import os

from launcher.base.model.ros_arguments import full_node_name
from launcher.base.model.spec import ProcessSpec

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.base.model.events import LoadRequest
    from launcher.language.diagnostics.origin import FileLine
    from launcher.language.interpreter.run_host import RunHost


class _Node:
    """`process` is the one that it lives in; None if that is not known."""

    def __init__(self, what: str, origin: FileLine | None, process: Any) -> None:
        self.what = what
        self.origin = origin
        self.process = process

    @property
    def exists(self) -> bool:
        return self.process is None or bool(self.process.active)

    def __str__(self) -> str:
        return self.what if self.origin is None else f"{self.what} ({self.origin})"


class NodeNames:
    """The nodes of a run by their names, and then by domain."""

    def __init__(self, host: RunHost) -> None:
        self._host = host
        self._nodes: dict[str, dict[str, _Node]] = {}

    def add_process(self, spec: ProcessSpec, process: Any) -> None:
        """A process is about to start, which may be a node."""
        name = full_node_name(spec.argv)
        if name is not None:
            domain = spec.env.get("ROS_DOMAIN_ID") or "0"
            self._add(domain, name, _Node(spec.name, process.action._origin, process))

    def add_component(self, request: LoadRequest, origin: FileLine | None) -> None:
        """A node is about to be loaded; its name may be unknown."""
        if not request.name:
            return
        container = f"/{request.container.lstrip('/')}"
        domain, process = os.environ.get("ROS_DOMAIN_ID") or "0", None
        for its_domain, node in self._nodes.get(container, {}).items():
            domain, process = its_domain, node.process
        name = f"/{request.namespace or ''}/{request.name}".replace("//", "/")
        name = f"/{name.strip('/')}"
        self._add(domain, name, _Node(f"{request.plugin} in {container}", origin, process))

    def _add(self, domain: str, name: str, node: _Node) -> None:
        others = self._nodes.setdefault(name, {})
        other = others.setdefault(domain, node)
        if other is node:
            return
        if other.exists:
            text = f"{node.what} and {other} have the same node name {name}"
            self._host.warn_quirk(text, node.origin)
        else:
            others[domain] = node
