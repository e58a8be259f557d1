"""The code of launch files, for messages: nodes at a line, places of entries and keywords."""

from __future__ import annotations

import ast
import functools

from launcher.language.diagnostics.origin import FileLine

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator


def nodes(path: str) -> Iterator[ast.AST]:
    """All nodes of a file, outer ones first; none if it is not Python."""
    import linecache

    tree = _tree("".join(linecache.getlines(path)))
    if tree is not None:
        yield from ast.walk(tree)


@functools.lru_cache(maxsize=8)
def _tree(text: str) -> ast.Module | None:
    try:
        return ast.parse(text)
    except (SyntaxError, ValueError, RecursionError):
        return None


def nodes_at(place: FileLine) -> Iterator[ast.expr]:
    """The expressions that begin or go on in this line, outer ones first.

    Those of a statement over several lines are found only where they have a part in the line.
    """
    for node in nodes(place.path):
        if isinstance(node, ast.expr):
            last = node.end_lineno or node.lineno
            if node.lineno <= place.line <= last:
                yield node


def call_at(place: FileLine, name: str) -> ast.Call | None:
    """The only call of this name that begins in the line."""
    found = [
        node
        for node in nodes_at(place)
        if isinstance(node, ast.Call)
        and node.lineno == place.line
        and getattr(node.func, "id", getattr(node.func, "attr", None)) == name
    ]
    return found[0] if len(found) == 1 else None


def first_read(path: str, name: str) -> FileLine | None:
    """Where a file first reads a name, unless it gives the name another value first."""
    found = [node for node in nodes(path) if isinstance(node, ast.Name) and node.id == name]
    if not found or not all(isinstance(node.ctx, ast.Load) for node in found):
        return None
    return FileLine(path, min(node.lineno for node in found))


def keyword_place(place: FileLine, call: str, keyword: str) -> FileLine | None:
    """The line of a keyword argument of the call that begins in the line of `place`."""
    node = call_at(place, call)
    for one in () if node is None else node.keywords:
        if one.arg == keyword:
            return FileLine(place.path, one.lineno)
    return None


def function_at(path: str, name: str, *, after: int = 1) -> ast.FunctionDef | None:
    """The first function of this name at or after a line."""
    for node in nodes(path):
        is_function = isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
        if is_function and node.name == name and node.lineno >= after:  # type: ignore[attr-defined]
            return node  # type: ignore[return-value]
    return None


def own_nodes(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a function without those of nested functions."""
    for child in ast.iter_child_nodes(node):
        yield child
        if not isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
            yield from own_nodes(child)
