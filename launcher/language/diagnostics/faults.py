"""Converts exceptions of launch files to errors with file, line and hint."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Iterator
from types import TracebackType

from launcher.base import text_file
from launcher.base.errors import LauncherError, LaunchFileError
from launcher.language.diagnostics import hints, includes, wrong_objects, wrong_types
from launcher.language.diagnostics.error_details import details
from launcher.language.diagnostics.origin import FileLine, is_library, is_own_file
from launcher.language.diagnostics.own_faults import doubt, own_fault
from launcher.language.sources import InvalidLaunchFileError, is_interrupt

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.context import LaunchContext

_LAUNCH_ENDINGS = ("launch.py", "launch.xml", "launch.yaml", "launch.yml")
_NULL_BYTES = "source code string cannot contain null bytes"
_QUOTED = re.compile(r"['\"]([^'\"]+)['\"]")


def explain(
    error: BaseException, path: str, context: LaunchContext | None = None
) -> LaunchFileError:
    """A LaunchFileError with the place in the launch file, if it can be found.

    The exception is its `__cause__`. With a `context`, hints suggest names that exist. Raises
    KeyboardInterrupt for an exception that Python has made of one.
    """
    entity = getattr(details(error).entity, "_origin", None)
    if isinstance(error, InvalidLaunchFileError) and error.__cause__ is not None:
        error = error.__cause__
    if is_interrupt(error):
        raise KeyboardInterrupt
    cycle = includes.cycle(context) if _is_endless(error) else None
    if cycle is not None:
        known = details(error)
        known.message, known.place, known.hint = *cycle, hints.ENDLESS
    elif isinstance(error, LaunchFileError) and error.where is not None:
        return error
    undecodable = _undecodable(error, path)
    if undecodable is not None:
        undecodable.__cause__ = error
        return undecodable
    place = details(error).place or _place(error, path, entity)
    if not wrong_objects.none_is_given(error, place):
        mistake = own_fault(error, None if place is None else str(place))
        if mistake is not None:
            return mistake
    fault = _fault(error, place, context)
    fault.__cause__ = error
    return fault


def _fault(
    error: BaseException, place: FileLine | None, context: LaunchContext | None
) -> LaunchFileError:
    known = details(error)
    message, word = known.message or _message(error), known.word
    sentence = None if known.message else wrong_types.sentence(error, place)
    if sentence is None:
        hint = hints.declared_below(message, place) or hints.hint(error, message, context, place)
        hint = hint or doubt(error)
        message = hints.without_hint(message)
    else:
        message, hint, word = sentence.message, sentence.hint, sentence.word
        place = sentence.place or place
    line = None if place is None else _source_line(place)
    return LaunchFileError(
        message,
        hint=hint,
        where=None if place is None else str(place),
        source_line=line,
        column=None if line is None else _column(error, message, line, word),
    )


def _is_endless(error: BaseException | None) -> bool:
    """Whether it is, or comes from, the end of a recursion, which a parser may have reported."""
    while error is not None:
        if isinstance(error, RecursionError) or "RecursionError" in getattr(error, "ros_type", ""):
            return True
        error = error.__cause__
    return False


# ---- message


def _message(error: BaseException) -> str:
    if isinstance(error, LauncherError):
        return error.message.strip('"')
    if isinstance(error, RecursionError):
        return "the launch file includes itself, or recurses endlessly"
    if isinstance(error, SystemExit):
        return f"the launch file calls sys.exit({error.code!r})"
    if isinstance(error, SyntaxError):
        return error.msg
    text = str(error)
    if not text:
        return type(error).__name__
    is_clear = isinstance(error, (RuntimeError, ValueError, ImportError))
    if is_clear or type(error).__module__ != "builtins":
        return text
    return f"{type(error).__name__}: {text}"


# ---- place


def _place(error: BaseException, path: str, entity: FileLine | None) -> FileLine | None:
    written = _written_at(error)
    if written is not None:
        return written
    places = list(_frames(error.__traceback__))
    if entity is not None:
        places.insert(0, entity)
    in_launch_files = [place for place in places if _is_launch_file(place.path, path)]
    if in_launch_files or places:
        # A recursion may end anywhere: show its start.
        innermost = 0 if isinstance(error, RecursionError) else -1
        return (in_launch_files or places)[innermost]
    return FileLine(path, 1) if os.path.isfile(path) else None


def _written_at(error: BaseException) -> FileLine | None:
    """The place of a syntax error in a file, which an expression has none of."""
    if not isinstance(error, SyntaxError) or not error.filename or not error.lineno:
        return None
    return None if error.filename[0] == "<" else FileLine(error.filename, error.lineno)


def _frames(trace: TracebackType | None) -> Iterator[FileLine]:
    """Frames outside of the launcher and of installed libraries, outermost first."""
    while trace is not None:
        name = trace.tb_frame.f_code.co_filename
        if not name.startswith("<") and not is_own_file(name) and not is_library(name):
            yield FileLine(name, trace.tb_lineno)
        trace = trace.tb_next


def _is_launch_file(name: str, path: str) -> bool:
    return name == path or name.endswith(_LAUNCH_ENDINGS)


def _source_line(place: FileLine) -> str | None:
    import linecache

    return linecache.getline(place.path, place.line).rstrip("\n") or None


def _column(error: BaseException, message: str, line: str, word: str | None) -> int:
    """The column (from 1) of the word or the text quoted by the message, else of the first word."""
    if isinstance(error, SyntaxError) and error.offset and _written_at(error):
        return min(error.offset, len(line) + 1)
    found = re.search(rf"(?<!\w){re.escape(word)}(?!\w)", line) if word else None
    if found is not None:
        return found.start() + 1
    for quoted in _QUOTED.findall(message):
        if quoted in line:
            return line.index(quoted) + 1
    return len(line) - len(line.lstrip()) + 1


# ---- encoding


def _is_pointer(path: str) -> bool:
    try:
        with open(path, "rb") as file:
            return text_file.is_pointer(file.read(len(text_file.POINTER)))
    except (OSError, ValueError):  # the name of a piece of code that is in no file
        return False


def _undecodable(error: BaseException, path: str) -> LaunchFileError | None:
    """The error about a file that is not UTF-8, at that line, or no text; None if it is UTF-8."""
    name = getattr(error, "filename", None) or path
    if isinstance(error, SyntaxError) and _is_pointer(name):
        return LaunchFileError(
            text_file.pointer_sentence("it"), hint=text_file.POINTER_HINT, where=name
        )
    for one in (error, error.__cause__, error.__context__):
        if isinstance(one, OSError) and one.errno == errno.EFBIG:  # its lines are not to be read
            message = f"cannot read the file: {one.strerror}"
            return LaunchFileError(message, where=str(one.filename or path))
    if isinstance(error, (SyntaxError, ValueError)) and _NULL_BYTES in str(error):
        return LaunchFileError("the launch file is not a text file", where=name)
    is_coding = isinstance(error, SyntaxError) and "codec can't decode" in str(error.msg)
    if not is_coding and not isinstance(error, UnicodeDecodeError):
        return None
    try:
        with open(name, "rb") as file:
            data = file.read()
        data.decode()
    except UnicodeDecodeError as wrong:
        line = data.count(b"\n", 0, wrong.start) + 1
        return LaunchFileError(
            f"the byte 0x{data[wrong.start]:02x} is not UTF-8",
            hint="save the file as UTF-8, or name its encoding in the first line: "
            "# -*- coding: latin-1 -*-",
            where=str(FileLine(name, line)),
        )
    except OSError:
        return None
    return None
