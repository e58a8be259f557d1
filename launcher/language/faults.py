"""Faults: an exception of a launch file as an error that names the file and the line."""

from __future__ import annotations

import os
from types import TracebackType

from launcher.errors import LauncherError, LaunchFileError
from launcher.language.origin import Origin, is_own_file
from launcher.language.sources import InvalidLaunchFileError


def explain(error: BaseException, path: str) -> LaunchFileError:
    """A LaunchFileError with the place in the launch file, as well as it can be found.

    The exception is its `__cause__`.
    """
    if isinstance(error, InvalidLaunchFileError) and error.__cause__ is not None:
        error = error.__cause__
    if isinstance(error, LaunchFileError) and error.where is not None:
        return error
    place = _place(error, path)
    message = _message(error)
    fault = LaunchFileError(
        message,
        hint=error.hint if isinstance(error, LauncherError) else None,
        where=None if place is None else str(place),
        source_line=None if place is None else _source_line(place),
    )
    fault.__cause__ = error
    return fault


def _message(error: BaseException) -> str:
    if isinstance(error, LauncherError):
        return error.message
    if isinstance(error, RecursionError):
        return "the launch file includes itself, or recurses without end"
    text = str(error)
    if isinstance(error, SyntaxError):
        return error.msg
    if not text:
        return type(error).__name__
    expected = isinstance(error, (RuntimeError, ValueError)) or not _is_builtin(error)
    return text if expected else f"{type(error).__name__}: {text}"


def _is_builtin(error: BaseException) -> bool:
    return type(error).__module__ == "builtins"


def _place(error: BaseException, path: str) -> Origin | None:
    if isinstance(error, SyntaxError) and error.filename and error.lineno:
        return Origin(error.filename, error.lineno)
    frame = _innermost(error.__traceback__)
    entity = getattr(error, "_launcher_origin", None)
    if isinstance(entity, Origin):
        return entity if frame is None else frame
    if frame is not None:
        return frame
    return Origin(path, 1) if os.path.isfile(path) else None


def _innermost(trace: TracebackType | None) -> Origin | None:
    """The innermost frame of a file that is neither ours nor of the standard library."""
    found = None
    while trace is not None:
        name, line = trace.tb_frame.f_code.co_filename, trace.tb_lineno
        trace = trace.tb_next
        if not name.startswith("<") and not is_own_file(name) and not _is_library(name):
            found = Origin(name, line)
    return found


def _is_library(name: str) -> bool:
    return "/site-packages/" in name or name.startswith(os.path.dirname(os.__file__) + "/")


def _source_line(place: Origin) -> str | None:
    import linecache

    line = linecache.getline(place.path, place.line).rstrip("\n")
    return line or None
