"""Where an entry of an expectation file was written, for errors that show the line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from launcher.base.errors import LauncherError, LaunchFileError, UsageError

TYPE_CHECKING = False
if TYPE_CHECKING:
    import yaml

    _Entry = tuple[yaml.Node | None, yaml.Node]  # node of the key, node of the value

KeyPath = tuple[object, ...]


class SourceMap:
    """Finds the lines of key paths in a YAML text, of which `root` is the node.

    The children of a node are indexed once, however many paths are looked up.
    """

    def __init__(self, text: str, path: str) -> None:
        self.lines = text.splitlines()
        self.root: yaml.Node | None = None
        self._path = path
        self._children: dict[int, dict[object, _Entry]] = {}

    def error_at(self, mark: yaml.Mark, message: str, hint: str | None = None) -> LauncherError:
        """A mistake at a position that YAML's reader gives."""
        return LaunchFileError(
            message,
            hint=hint,
            where=f"{self._path}:{mark.line + 1}",
            source_line=self.lines[mark.line] if mark.line < len(self.lines) else "",
            column=mark.column + 1,
        )

    def error(
        self, path: KeyPath, message: str, hint: str | None = None, *, value: bool = False
    ) -> LauncherError:
        """A mistake at the key (or the value) of the path, or at its nearest existing parent."""
        return self.error_at(self._mark(path, value=value), message, hint)

    def origin(self, path: KeyPath) -> Origin:
        line = self._mark(path, value=False).line + 1
        return Origin(text=self._path, line=line, map=self, path=path)

    def _mark(self, path: KeyPath, *, value: bool) -> yaml.Mark:
        assert self.root is not None
        node, mark = self.root, self.root.start_mark
        for key in path:
            found = self._inside(node).get(key)
            if found is None:
                break
            key_node, node = found
            mark = (node if value or key_node is None else key_node).start_mark
        return mark

    def _inside(self, node: yaml.Node) -> dict[object, _Entry]:
        known = self._children.get(id(node))
        if known is None:
            known = {name: (key, child) for name, key, child in entries_of(node)}
            self._children[id(node)] = known
        return known


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """Where something was written: a file and a line, or an option of the command line."""

    text: str
    line: int = 0
    map: SourceMap | None = None
    path: KeyPath = ()

    def __str__(self) -> str:
        return f"{self.text}:{self.line}" if self.line else self.text

    def error(self, message: str, hint: str | None = None, *keys: object) -> LauncherError:
        """A mistake there, in the value of these keys."""
        if self.map is not None:
            return self.map.error((*self.path, *keys), message, hint, value=bool(keys))
        return UsageError(f"{self.text}: {message}", hint=hint)


def entries_of(node: yaml.Node) -> Iterator[tuple[object, yaml.Node | None, yaml.Node]]:
    """(key or index, node of the key, node of the value) of the children of a node."""
    import yaml

    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            yield str(getattr(key, "value", "")), key, value
    elif isinstance(node, yaml.SequenceNode):
        for index, value in enumerate(node.value):
            yield index, None, value
