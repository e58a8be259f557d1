"""What a file of tests raises: its line, and whether the file asks to be skipped."""

from __future__ import annotations

import sys
import unittest


def skips() -> tuple[type[BaseException], ...]:
    """The exceptions that skip: pytest's, too, if the tests have imported pytest."""
    pytest = sys.modules.get("pytest")
    return (unittest.SkipTest,) if pytest is None else (unittest.SkipTest, pytest.skip.Exception)


def fault_line(error: BaseException, path: str) -> int | None:
    """The line of this file that raised an error or called what did; None: no line of it."""
    if isinstance(error, SyntaxError) and error.filename == path:
        return error.lineno
    found, trace = None, error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == path:
            found = trace.tb_lineno
        trace = trace.tb_next
    return found


def fault_text(error: BaseException, path: str) -> str:
    """One sentence; an exit is the call that makes it."""
    if isinstance(error, SystemExit):
        given = "" if error.code is None else repr(error.code)
        return f"sys.exit({given}) ends the program, and no test runs"
    if isinstance(error, SyntaxError) and error.filename == path:
        return f"SyntaxError: {error.msg}"  # the whole text repeats file and line
    if type(error) is Exception:  # ours say everything in their text
        return str(error)
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
