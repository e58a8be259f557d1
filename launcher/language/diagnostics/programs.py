"""Programs that are given as launch files: they are refused before they are executed."""

from __future__ import annotations

import ast
import os
import re
import shlex

from launcher.base.text import shown_path
from launcher.language.diagnostics.error_details import details
from launcher.language.diagnostics.origin import FileLine

# Any of these may bind a name that the file does not have.
_DYNAMIC = re.compile(
    r"\b(?:globals|locals|vars|setattr|exec|eval|__dict__|__getattr__|modules|_getframe"
    r"|currentframe|stack|f_globals|__globals__)\b"
)
_SHELL = re.compile(rb"#!.*\b(?:ba|da|k|z)?sh\b")
_IMPORTS = (ast.Import, ast.ImportFrom)
_DOES = (ast.Expr, ast.For, ast.While, ast.With, ast.Try)


def explain(error: BaseException, source: bytes, path: str, required: str) -> bool:
    """Whether a file without this function is a program; that is then attached to the error.

    False if the function may exist once the file is executed, and for a file that has the name or
    the imports of a launch file: what is raised by its execution says more.
    """
    line = _evidence(source, path, required)
    if line is None:
        return False
    name, file = os.path.basename(path), shown_path(os.path.relpath(path))
    program = file if os.sep in file else f"./{file}"
    alone = f"python3 {shlex.quote(file)}"
    if _SHELL.match(source):
        alone = shlex.quote(program)
    known = details(error)
    known.message = f"{name} does not define {required}(): it is a program, not a launch file"
    known.place = FileLine(path, line)
    known.hint = f"write Node(executable={program!r}) into a launch file, or run it alone: {alone}"
    return True


def _evidence(source: bytes, path: str, required: str) -> int | None:
    """The line that shows a program; None if it may be a launch file."""
    try:
        tree = ast.parse(source)
        dump = ast.dump(tree)
    except (SyntaxError, ValueError, RecursionError):
        return 1 if _SHELL.match(source) else None
    is_named = path.endswith("launch.py") and "__main__" not in dump
    if is_named or required in dump or _DYNAMIC.search(dump) or _imports_launch(tree):
        return None
    return next((node.lineno for node in tree.body if _is_of_program(node)), None)


def _imports_launch(tree: ast.Module) -> bool:
    """Whether a package about launch files is imported, or all names of a module.

    Such packages may write the function into the module that imports them (better_launch).
    """
    for node in ast.walk(tree):
        names = [one.name for one in node.names] if isinstance(node, _IMPORTS) else []
        module = getattr(node, "module", None) if names else None
        if "*" in names or any("launch" in one for one in (*names, module or "")):
            return True
    return False


def _is_of_program(node: ast.stmt) -> bool:
    """Whether a launch file seldom has such a statement outside of functions: a call, a loop."""
    if isinstance(node, ast.If):
        return "__main__" in ast.dump(node.test)
    is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    return isinstance(node, _DOES) and not is_text
