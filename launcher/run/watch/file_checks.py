"""Whether a file has changed, and can be loaded: Python that compiles, parameters of rcl."""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Iterator

from launcher.base import yaml_bounds
from launcher.base.errors import LauncherError
from launcher.base.model.parameter_sections import PARAMETERS
from launcher.base.model.record import Record
from launcher.base.text import error_text

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def error_in(path: str, *, is_parameters: bool) -> LauncherError | None:
    """What is wrong with it; None if nothing is, or if it cannot be read."""
    content = content_of(path)
    if content is None:
        return None
    if is_parameters:
        return _of_parameters(path, content)
    if path.endswith(".py") or (content.startswith(b"#!") and b"python" in content[:256]):
        return _of_python(path, content)
    return None


def _of_python(path: str, content: bytes) -> LauncherError | None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            compile(content, path, "exec", dont_inherit=True)
    except SyntaxError as error:
        return LauncherError(
            error.msg,
            where=f"{path}:{error.lineno}" if error.lineno else path,
            source_line=(error.text or "").rstrip() or None,
            column=error.offset,
        )
    except (ValueError, RecursionError, MemoryError) as error:
        return LauncherError(error_text(error), where=path)
    return None


def _of_parameters(path: str, content: bytes) -> LauncherError | None:
    import yaml

    try:
        root = yaml_bounds.compose(content.decode(), yaml.SafeLoader)
        yaml.safe_load(content)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        text = error.problem or error.context or "not valid YAML"
        return LauncherError(text, **({} if mark is None else _place(path, content, mark)))
    except (yaml.YAMLError, ValueError) as error:
        return LauncherError(str(error).splitlines()[0], where=path)
    if root is None:
        return None
    for text, mark in _wrong(root):
        return LauncherError(text, **_place(path, content, mark))
    return None


def _place(path: str, content: bytes, mark: Any) -> dict[str, Any]:
    lines = content.decode(errors="replace").split("\n")
    line = lines[mark.line] if mark.line < len(lines) else ""
    return {
        "where": f"{path}:{mark.line + 1}",
        "source_line": line or None,
        "column": mark.column + 1,
    }


def _wrong(node: Any) -> Iterator[tuple[str, Any]]:
    """(what, where) is not in the form `NODE: {ros__parameters: {NAME: VALUE}}`."""
    if not hasattr(node, "value") or not isinstance(node.value, list) or node.id != "mapping":
        yield f"expected the name of a node, and '{PARAMETERS}:' below it", node.start_mark
        return
    for key, value in node.value:
        is_empty = value.id == "scalar" and value.tag.endswith(":null")
        if key.value == PARAMETERS:
            if value.id != "mapping" and not is_empty:
                yield f"expected names and values below '{PARAMETERS}'", value.start_mark
        elif value.id != "mapping":
            yield f"expected '{PARAMETERS}:' below '{key.value}'", key.start_mark
        else:
            yield from _wrong(value)


def forget_byte_code(path: str) -> None:
    """Delete the byte code of a source file that was changed twice within one second.

    Python takes it for current if the file has the same size and the same second.
    """
    import importlib.util

    if path.endswith(".py"):
        try:
            os.unlink(importlib.util.cache_from_source(path))
        except (OSError, NotImplementedError, ValueError):
            return


class State(Record):
    """A file at one moment; a file that does not exist has no `stamp`.

    `changed_ns`: when its content was changed or it was put there, in nanoseconds since 1970.
    """

    stamp: tuple[int, ...] | None = None
    changed_ns: int = 0


def state_of(path: str) -> State:
    """Its present state; a link has changed also if it leads elsewhere."""
    try:
        link, file = os.lstat(path), os.stat(path)
    except OSError:
        return State()
    stamp = (file.st_dev, file.st_ino, file.st_size, file.st_mtime_ns, file.st_ctime_ns)
    return State((*stamp, link.st_ino), max(link.st_ctime_ns, file.st_ctime_ns))


def content_of(path: str) -> bytes | None:
    """None if it cannot be read."""
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError:
        return None


def digest_of(path: str) -> str | None:
    """Equal for equal contents; None if it cannot be read."""
    content = content_of(path)
    return None if content is None else hashlib.blake2b(content, digest_size=16).hexdigest()
