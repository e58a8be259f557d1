"""Which source files and modules a Python program imports, found without running it.

Imports are followed through the user's own code: all that is neither in the standard library nor
in the `site-packages` of the interpreter (workspaces, source folders, editable installations).
What is imported under a computed name is not found.
"""

from __future__ import annotations

import ast
import functools
import importlib.machinery
import os
import site
import sys
from collections.abc import Iterable, Iterator, Sequence
from importlib.machinery import ModuleSpec, PathFinder

from launcher.packages.extras import PATH_ONLY

TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.metadata import Distribution

_SOURCE = tuple(importlib.machinery.SOURCE_SUFFIXES)


class Imports:
    """What was found.

    `files` are the user's source files, the program first; `modules` the names of those that are
    imported -> file. `installed` are modules of the standard library and of installed packages,
    as they are named in the imports; `deferred` those that only a function imports. `attributes`
    are what is taken from `installed` modules: (module, name). `missing` were not found. Of the
    user's packages without an `__init__.py` only the modules are noted.
    """

    def __init__(self) -> None:
        self.files: list[str] = []
        self.modules: dict[str, str] = {}
        self.installed: dict[str, None] = {}
        self.deferred: dict[str, None] = {}
        self.attributes: dict[tuple[str, str], None] = {}
        self.missing: dict[str, None] = {}


def imports_of(script: str = "", module: str = "", *, path: Sequence[str] | None = None) -> Imports:
    """The imports of a script or, as for `python -m`, a module, and of all that they import.

    `path` is the `sys.path` of the program (None: ours). No error for files that cannot be read or
    compiled: their imports are not known.
    """
    return imports_of_all([(script, module)], path=path)


def imports_of_all(
    programs: Iterable[tuple[str, str]], *, path: Sequence[str] | None = None
) -> Imports:
    """The imports of several programs with the same `path`; each is a script or a module."""
    search = _ImportSearch(list(sys.path if path is None else path))
    for script, module in programs:
        if module:
            search.follow(module, is_deferred=False)
            search.follow(f"{module}.__main__", is_deferred=False, is_optional=True)
        else:
            search.read(os.path.abspath(script), "__main__")
        search.run()
    return search.found


class _ImportSearch:
    """Follows imports; `_waiting` has the files to read, with the names of their modules."""

    def __init__(self, path: list[str]) -> None:
        self.found = Imports()
        self._path = path
        self._specs: dict[str, ModuleSpec | None] = {}
        self._waiting: list[tuple[str, str]] = []

    def run(self) -> None:
        while self._waiting:
            self._read(*self._waiting.pop(0))

    def read(self, file: str, module: str) -> None:
        """Read this file of the user's, once."""
        if file not in self.found.files:
            self.found.files.append(file)
            self._waiting.append((file, module))

    def _read(self, file: str, module: str) -> None:
        try:
            with open(file, "rb") as source:
                tree = ast.parse(source.read(), file)
        except (OSError, SyntaxError, ValueError, RecursionError):
            return
        self._extend_path(tree)
        is_package = os.path.basename(file).startswith("__init__.")
        package = module if is_package else module.rpartition(".")[0]
        for node, is_deferred in _imports(tree):
            if isinstance(node, ast.Import):
                for alias in node.names:
                    self.follow(alias.name, is_deferred=is_deferred)
            elif base := _base(node, package):
                self._from(base, node, is_deferred)
        for name in _entry_points(tree, self._path):
            self.follow(name, is_deferred=False)
        self._note_attributes(tree)

    def _extend_path(self, tree: ast.Module) -> None:
        """Follow the changes of `sys.path` that a program makes, as our own scripts do."""
        for first, last in map(_folders_of_path, tree.body):
            if first or last:
                self._path = [*first, *self._path, *last]
                self._specs.clear()

    def _from(self, base: str, node: ast.ImportFrom, is_deferred: bool) -> None:
        self.follow(base, is_deferred=is_deferred)
        for alias in node.names:
            name = f"{base}.{alias.name}"
            self.follow(name, is_deferred=is_deferred, is_optional=True)
            if base in self.found.installed and name not in self.found.installed:
                self.found.attributes[base, alias.name] = None

    def _note_attributes(self, tree: ast.AST) -> None:
        """`std_msgs.msg.String` after `import std_msgs.msg`."""
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute):
                base, _, name = _dotted(node).rpartition(".")
                if base in self.found.installed and "." in base:
                    self.found.attributes[base, name] = None

    def follow(self, name: str, *, is_deferred: bool, is_optional: bool = False) -> None:
        """Note a module, and its packages; read those of the user."""
        parts = name.split(".")
        for length in range(1, len(parts) + 1):
            part = ".".join(parts[:length])
            spec = self._find(part)
            if spec is None:
                if not is_optional:
                    self.found.missing[name] = None
                return
            self._note(part, spec, is_deferred)

    def _note(self, name: str, spec: ModuleSpec, is_deferred: bool) -> None:
        file = spec.origin if spec.has_location else None
        places = list(spec.submodule_search_locations or ()) if file is None else [file]
        if any(not is_installed(place) for place in places if place):
            if file is not None:
                self.found.modules.setdefault(name, file)
                if file.endswith(_SOURCE):
                    self.read(file, name)
        elif not is_deferred:
            self.found.installed[name] = None
            self.found.deferred.pop(name, None)
        elif name not in self.found.installed:
            self.found.deferred[name] = None

    def _find(self, name: str) -> ModuleSpec | None:
        if name not in self._specs:
            try:
                self._specs[name] = self._find_new(name)
            except (ImportError, AttributeError, ValueError, OSError):
                self._specs[name] = None
        return self._specs[name]

    def _find_new(self, name: str) -> ModuleSpec | None:
        parent, _, _ = name.rpartition(".")
        if parent:
            above = self._find(parent)
            folders = above.submodule_search_locations if above is not None else None
            return None if folders is None else PathFinder.find_spec(name, list(folders))
        finders = [PathFinder] if name in PATH_ONLY else sys.meta_path
        for finder in finders:  # an editable installation adds one
            path = self._path if finder is PathFinder else None
            find_spec = getattr(finder, "find_spec", None)
            spec: ModuleSpec | None = None if find_spec is None else find_spec(name, path)
            if spec is not None:
                return spec
        return None


def _imports(tree: ast.AST) -> Iterator[tuple[ast.Import | ast.ImportFrom, bool]]:
    """(statement, whether it is in a function), without those for type checkers only."""
    waiting: list[tuple[ast.AST, bool]] = [(tree, False)]
    while waiting:
        node, is_deferred = waiting.pop()
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            yield node, is_deferred
            continue
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
            is_deferred = True
        children: Iterable[ast.AST] = ast.iter_child_nodes(node)
        if isinstance(node, ast.If) and _dotted(node.test).endswith("TYPE_CHECKING"):
            children = node.orelse
        waiting += [(child, is_deferred) for child in reversed(list(children))]


def _folders_of_path(node: ast.stmt) -> tuple[list[str], list[str]]:
    """Literal folders that a statement puts at the begin of `sys.path`, and at its end."""
    match node:
        case ast.Assign(
            targets=[ast.Subscript(value=path, slice=ast.Constant(value=0))],
            value=ast.Constant(value=str(folder)),
        ) if _dotted(path) == "sys.path":
            return [folder], []
        case ast.AugAssign(target=path, value=ast.List(elts=items)) if _dotted(path) == "sys.path":
            found = [one.value for one in items if isinstance(one, ast.Constant)]
            return [], [one for one in found if isinstance(one, str)]
        case ast.Expr(value=ast.Call(func=call, args=[*_, ast.Constant(value=str(folder))])):
            if _dotted(call) == "sys.path.insert":
                return [folder], []
            if _dotted(call) == "sys.path.append":
                return [], [folder]
    return [], []


def _dotted(node: ast.AST) -> str:
    """`a.b.c` of such an expression; empty for others."""
    parts: list[str] = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    return ".".join([node.id, *reversed(parts)]) if isinstance(node, ast.Name) else ""


def _base(node: ast.ImportFrom, package: str) -> str:
    """The absolute name of the module after `from`; empty outside of any package."""
    if not node.level:
        return node.module or ""
    parts = package.split(".") if package and package != "__main__" else []
    if len(parts) < node.level:
        return ""
    kept = parts[: len(parts) - node.level + 1]
    return ".".join([*kept, node.module] if node.module else kept)


def _entry_points(tree: ast.AST, path: list[str]) -> Iterator[str]:
    """Modules of `load_entry_point("package==1.0", "console_scripts", "name")`, as colcon's."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and _dotted(node.func).endswith("load_entry_point"):
            words = [one.value for one in node.args if isinstance(one, ast.Constant)]
            if len(words) == 3:
                package, group, name = map(str, words)
                yield from _modules_of(package.partition("==")[0], group, name, path)


def _modules_of(package: str, group: str, name: str, path: list[str]) -> Iterator[str]:
    from importlib import metadata

    found: Iterable[Distribution] = metadata.distributions(name=package, path=path)
    for distribution in found:
        for point in distribution.entry_points:
            if (point.group, point.name) == (group, name):
                yield point.module


# ---- whose code it is


def is_installed(file: str) -> bool:
    """Whether a file is of the standard library or of a package that pip has installed.

    What colcon has installed in a workspace is not: it is the user's.
    """
    return _real_folder(os.path.dirname(file)).startswith(_installed_folders())


@functools.lru_cache(4096)
def _real_folder(folder: str) -> str:
    return os.path.join(os.path.realpath(folder), "")


@functools.cache
def _installed_folders() -> tuple[str, ...]:
    import sysconfig

    names = ("stdlib", "platstdlib", "purelib", "platlib")
    folders = {sysconfig.get_path(name) for name in names}
    folders.update(site.getsitepackages([sys.prefix, sys.base_prefix]))
    if site.ENABLE_USER_SITE:
        folders.add(site.getusersitepackages())
    folders.add("/opt/ros")
    return tuple(os.path.join(os.path.realpath(folder), "") for folder in folders if folder)
