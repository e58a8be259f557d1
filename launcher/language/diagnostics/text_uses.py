"""Warnings about substitutions that a launch file uses as texts, where ROS 2 goes on.

A substitution becomes a text only when it is performed: an f-string holds the text of the object,
and a comparison with a text is always false.
"""

from __future__ import annotations

import ast
import os
import shutil
from types import FrameType

from launcher.language import launch_session
from launcher.language.diagnostics import source_code
from launcher.language.diagnostics.origin import FileLine, is_library

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.substitution import Substitution

_MAX_SHOWN = 100  # characters of code in a hint


def warn_of_str(sub: Substitution, frame: FrameType) -> None:
    """The launch file calls `str()` or uses an f-string: the text is that of the object."""
    origin = _user_origin(frame)
    if origin is not None:
        name = type(sub).__name__
        text = f"a {name} is used as text, which gives '<{type(sub).__module__}.{name} object ...>'"
        launch_session.current().warn(f"{text}; hint: {_list_instead(origin, sub)}", origin)


def warn_of_comparison(sub: Substitution, other: str, frame: FrameType) -> None:
    """The launch file compares a substitution with a text, which are never equal."""
    origin = _user_origin(frame)
    if origin is not None:
        written = _written(sub)
        text = f"a {type(sub).__name__} is compared with a text, and is never equal to it"
        hint = f"write condition=IfCondition(EqualsSubstitution({written}, {other!r}))"
        launch_session.current().warn(f"{text}; hint: {hint}", origin)


def warn_of_letters(keyword: str, value: object, origin: FileLine | None) -> None:
    """A text was given for a list of words, and each letter of it becomes a word."""
    if isinstance(value, str) and len(value) > 1:
        text = f"{keyword} is a text, of which each letter becomes a word"
        launch_session.current().warn(f"{text}; hint: write {keyword}={value.split()}", origin)


def warn_of_one_word(words: list[str], context: LaunchContext, action: Any) -> None:
    """The name of a program holds spaces, and no such program exists."""
    word = words[0]
    folder = action.process_description.final_cwd or "."
    if shutil.which(word) or os.path.exists(os.path.join(folder, word)):
        return
    text = f"'{word}' is one word, and there is no program of this name"
    first, *rest = word.split()
    in_python = action._origin is None or action._origin.is_python
    shell = "add shell=True" if in_python else 'add shell="true"'
    if hasattr(action, "node_executable"):
        hint = f"write executable='{first}', and the rest in arguments={rest}"
        if not in_python:
            hint = f'write exec="{first}", and the rest in args="{" ".join(rest)}"'
    elif set(word) & set("|&;<>$*`"):
        hint = shell
    else:
        split = [first, *rest, *words[1:]]
        hint = f"write cmd={split}, or {shell}"
        if not in_python:
            hint = f'write cmd="{" ".join(split)}", or {shell}'
    context._host.warn_quirk(f"{text}; hint: {hint}", action._origin)


def _user_origin(frame: FrameType) -> FileLine | None:
    """Where the code is, unless it belongs to a library."""
    path = frame.f_code.co_filename
    return None if path.startswith("<") or is_library(path) else FileLine(path, frame.f_lineno)


def _list_instead(origin: FileLine, sub: Substitution) -> str:
    """The pieces of the only f-string in this line as a list."""
    strings = [node for node in source_code.nodes_at(origin) if isinstance(node, ast.JoinedStr)]
    pieces: list[str] = []
    for piece in strings[0].values if len(strings) == 1 else ():
        if isinstance(piece, ast.FormattedValue):
            pieces.append(ast.unparse(piece.value))
        else:
            pieces.append(ast.unparse(piece))
    listed = f"[{', '.join(pieces)}]"
    if pieces and len(listed) <= _MAX_SHOWN:
        return f"write {listed}"
    return f"write a list, as in ['text', {_written(sub)}]"


def _written(sub: object) -> str:
    """The code that makes the substitution, as far as it is simple."""
    parts = getattr(sub, "variable_name", None) or [None]
    texts = [getattr(part, "text", None) for part in parts]
    name = "..." if None in texts else repr("".join(map(str, texts)))
    return f"{type(sub).__name__}({name})"
