"""Warns of parameter files that have nothing for any of the nodes that get them.

rcl ignores such a file without a word. A file that is also for a node whose name is set in
its program may be right, and is not reported.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping

from launcher.base import text_file
from launcher.base.model.parameter_sections import PARAMETERS, Section, sections
from launcher.base.model.ros_arguments import PARAMETER_FILE, full_node_name, ros_options
from launcher.base.model.spec import ProcessSpec
from launcher.base.text import several, shown_path, suggest

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.diagnostics.origin import FileLine


class ParameterFiles:
    """The files of a run that no node is known to use.

    `generated` are the contents of files that the launcher wrote, `sources` the files of which it
    has replaced the substitutions; `warn` gets a text and the place of the first node.
    """

    def __init__(
        self,
        generated: Mapping[str, Any],
        sources: Mapping[str, str],
        warn: Callable[[str, FileLine | None], None],
    ) -> None:
        self._generated = generated
        self._sources = sources
        self._warn = warn
        self._unused: dict[str, _File] = {}
        self._settled: set[str] = set()

    def add_process(self, spec: ProcessSpec, origin: FileLine | None) -> None:
        """A process is about to start, which may be a node."""
        name = full_node_name(spec.argv)
        for option, path in ros_options(spec.argv):
            if option is PARAMETER_FILE:
                self._add(path, name, origin, cwd=spec.cwd)

    def add_component(self, path: str, node: str | None, origin: FileLine | None) -> None:
        """A component with this full name gets the file, which may be names and values only."""
        self._add(path, node, origin, is_flat_allowed=True)

    def _add(
        self,
        given: str,
        node: str | None,
        origin: FileLine | None,
        *,
        cwd: str | None = None,
        is_flat_allowed: bool = False,
    ) -> None:
        """Judge the file for a node; None: its name is not known."""
        path = os.path.abspath(os.path.join(cwd or "", given))
        if path in self._settled:
            return
        file = self._unused.pop(path, None) or self._read(path, given, origin)
        if file is None or node is None or file.is_for(node) or (is_flat_allowed and file.is_flat):
            self._settled.add(path)
            return
        file.nodes.append(node)
        self._unused[path] = file

    def _read(self, path: str, given: str, origin: FileLine | None) -> _File | None:
        name = self._sources.get(path, given)
        if path in self._generated:
            return _File(name, origin, tree=self._generated[path])
        if not os.path.isfile(path):
            return None  # a pipe, perhaps, which only the node may read
        try:
            text = text_file.read(path)
        except (OSError, ValueError):
            return None  # the node will report it
        if text_file.is_pointer(text):
            what = text_file.pointer_sentence(f"the parameter file {shown_path(name)}")
            self._warn(f"{what}; hint: {text_file.POINTER_HINT}", origin)
            return None
        return _File(name, origin, text=text)

    @property
    def has_unused(self) -> bool:
        return bool(self._unused)

    def judge(self, *, is_more_expected: bool) -> None:
        """Warn; with more nodes to come, only of files that are probably for those known."""
        for path, file in tuple(self._unused.items()):
            if file.is_probable or not is_more_expected:
                self._settled.add(path)
                del self._unused[path]
                self._warn(file.warning(), file.origin)


class _File:
    """A file, and nodes for which it has nothing. Its text is parsed only if it has to be."""

    def __init__(
        self, path: str, origin: FileLine | None, *, text: str = "", tree: object = None
    ) -> None:
        self.path = path
        self.origin = origin
        self.nodes: list[str] = []
        self._text = text
        self._tree = tree
        self._sections: list[Section] | None = None

    def is_for(self, node: str) -> bool:
        """Whether it has something for a node, or nothing at all."""
        if self._sections is None:
            key = rf"^[\"']?(/\*\*|/?{re.escape(node[1:])})[\"']?:"
            if PARAMETERS in self._text and re.search(key, self._text, re.MULTILINE):
                return True
            self._sections = self._parsed()
        return not self._tree or any(section.is_for(node) for section in self._sections)

    def _parsed(self) -> list[Section]:
        import yaml

        from launcher.base import yaml_bounds

        try:
            if self._text:
                node = yaml_bounds.compose(self._text)
                self._tree = node if getattr(node, "id", "") == "mapping" else None
            return list(sections(self._tree))
        except (yaml.YAMLError, ValueError, RecursionError):
            self._tree = None  # the node will report it
            return []

    @property
    def _selectors(self) -> list[str]:
        return [section.selector for section in self._sections or ()]

    @property
    def is_flat(self) -> bool:
        """Whether it has no names of nodes; known after `is_for`."""
        return not self._sections

    @property
    def is_probable(self) -> bool:
        """Whether a key is nearly the name of a node, or there is no name at all."""
        return self.is_flat or any(self._meant(node) for node in self.nodes)

    def _meant(self, node: str) -> str | None:
        """The key that was probably meant for a node."""
        name = node.rpartition("/")[2]
        same = [one for one in self._selectors if one.rpartition("/")[2] == name]
        return same[0] if same else suggest(node, self._selectors)

    def warning(self) -> str:
        node = next(filter(self._meant, self.nodes), self.nodes[0])
        name, key = node.rpartition("/")[2], self._meant(node)
        what = f"the parameter file {shown_path(self.path)}"
        if self.is_flat:
            text = f"{what} has no '{PARAMETERS}:', so that {several(self.nodes)} cannot read it"
            return f"{text}; hint: write '{node}:' and '{PARAMETERS}:' above its names"
        known = sorted(self._selectors, key=lambda one: one != key)
        hint = f"write '{node}:'"
        if key is None:
            hint += ", or '/**:' for all nodes"
        elif key.rpartition("/")[2] == name:
            hint += f", or '/**/{name}:' for any namespace"
        else:
            hint += f" instead of '{key}:'"
        nodes = several(self.nodes)
        return f"{what} has nothing for {nodes}: it is for {several(known)}; hint: {hint}"
