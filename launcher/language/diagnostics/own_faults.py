"""Exceptions that are faults of the launcher, and not of the launch file that it evaluates."""

from __future__ import annotations

import opcode
import os
import re

from launcher.base.errors import ExitCode, LaunchFileError
from launcher.base.text import typed_error
from launcher.language.diagnostics.origin import is_own_file

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import TracebackType

_RAISE = opcode.opmap["RAISE_VARARGS"]
_STANDARD_LIBRARY = os.path.dirname(os.__file__) + "/"
_OF_A_VALUE = (OSError, ImportError, SyntaxError, MemoryError, RecursionError)
# A function of the launch file that is called with what ROS 2 calls it with, or the reverse.
_OF_A_CALL = re.compile(r"\) (takes|missing|got) |object is not (iterable|callable)|be an iterable")


class LauncherFault(LaunchFileError):
    """The launcher itself failed while it evaluated a launch file."""

    exit_code = ExitCode.PROCESS_FAILED


def own_fault(error: BaseException, where: str | None) -> LauncherFault | None:
    """The error to show if the launcher's own code failed; None for errors of the launch file.

    What this code raises on purpose, with `raise`, is about a value of the launch file. Any other
    exception that begins here (an index out of range, an attribute that None lacks) is a mistake.
    """
    if not isinstance(error, Exception) or not _is_mistake(error):
        return None
    place = _own_place(error)
    if place is None:
        return None
    fault = LauncherFault(
        f"the launcher failed here: {typed_error(error)} ({place})",
        hint="this is a fault of the launcher, not of the launch file; "
        "please report it with the traceback, which --debug prints",
        where=where,
    )
    fault.__cause__ = error
    return fault


def doubt(error: BaseException) -> str | None:
    """A hint for an error which a wrong value in the launch file explains, or a fault of ours."""
    if not isinstance(error, (AttributeError, TypeError)) or _OF_A_CALL.search(str(error)):
        return None
    place = _own_place(error)
    if place is None:
        return None
    return (
        f"raised in the launcher's own code, {place}; if the values in this entry are right, "
        "please report it with the traceback, which --debug prints"
    )


def _is_mistake(error: Exception) -> bool:
    if isinstance(error, (LaunchFileError, *_OF_A_VALUE)):
        return False
    if isinstance(error, ValueError):
        return "to unpack" in str(error)  # others are about the text of a value
    if isinstance(error, (AttributeError, TypeError)):
        # About another value than None: a launch file passed one of a wrong type, see `doubt`.
        return "NoneType" in str(error) and not _OF_A_CALL.search(str(error))
    return True


def _own_place(error: BaseException) -> str | None:
    """Where the launcher's code made the exception happen without raising it on purpose."""
    frame = _origin(error.__traceback__)
    if frame is None:
        return None
    code = frame.tb_frame.f_code
    if not is_own_file(code.co_filename) or code.co_code[frame.tb_lasti] == _RAISE:
        return None
    return f"{code.co_filename}:{frame.tb_lineno}"


def _origin(trace: TracebackType | None) -> TracebackType | None:
    """The innermost frame that is not in the standard library."""
    found = None
    while trace is not None:
        name = trace.tb_frame.f_code.co_filename
        is_library = name.startswith(_STANDARD_LIBRARY) and "/site-packages/" not in name
        if is_own_file(name) or not is_library:
            found = trace
        trace = trace.tb_next
    return found
