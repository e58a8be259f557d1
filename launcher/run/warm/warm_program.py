"""Runs a Python program in this process as `python FILE` or `python -m MODULE` would."""

from __future__ import annotations

import builtins
import os
import sys
from importlib.machinery import SourceFileLoader

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping
    from types import CodeType, ModuleType, TracebackType
    from typing import Any


class Program:
    """Sets `sys` and `__main__`; `run` is the last call of the process.

    It returns or raises as the program does, so that the interpreter ends as ever: exit code,
    threads, `atexit`, flushing, and its own SIGINT after a KeyboardInterrupt.
    """

    def __init__(self, content: Mapping[str, Any]) -> None:
        self._script: str = content["script"]
        self._module: str = content["module"]
        sys.executable = content["interpreter"]
        sys.orig_argv[:] = content["orig_argv"]
        sys.argv[:] = [self._script or "-m", *content["words"]]
        if not getattr(sys.flags, "safe_path", False):
            sys.path.insert(0, content["folder"])
        self._main = _fresh_main()

    def run(self) -> None:
        try:
            if self._module:
                import runpy

                runpy._run_module_as_main(self._module)  # type: ignore[attr-defined]
            else:
                exec(self._code(), vars(self._main))
        except SystemExit:
            raise
        except BaseException as error:
            _hide_our_frames(error)
            raise

    def _code(self) -> CodeType:
        path = os.path.abspath(self._script)
        facts = {"__file__": path, "__cached__": None}
        vars(self._main).update(facts, __loader__=SourceFileLoader("__main__", path))
        with open(path, "rb") as file:
            return compile(file.read(), path, "exec", dont_inherit=True)


def _fresh_main() -> ModuleType:
    """The module `__main__` as the interpreter makes it."""
    old = sys.modules["__main__"]
    new = type(old)("__main__")
    if sys.version_info < (3, 14):
        vars(new)["__annotations__"] = {}
    vars(new)["__builtins__"] = builtins
    sys.modules["__main__"] = new
    return new


def _hide_our_frames(error: BaseException) -> None:
    """Let the traceback of an uncaught exception begin where the program does.

    The interpreter adds the frames through which it is raised, and then calls the hook, which we
    replace for this one call.
    """
    hook = sys.excepthook
    above = error.__traceback__
    while above is not None and above.tb_frame.f_globals is globals():
        above = above.tb_next

    def show(kind: type[BaseException], value: BaseException, _: TracebackType | None) -> None:
        sys.excepthook = hook
        value.__traceback__ = sys.last_traceback = above
        try:
            hook(kind, value, above)
        except SystemExit:
            raise
        except BaseException as fault:
            _show_fault_of_hook(fault, value)

    sys.excepthook = show


def _show_fault_of_hook(fault: BaseException, value: BaseException) -> None:
    """As PyErr_PrintEx does it."""
    inner = fault.__traceback__ and fault.__traceback__.tb_next
    print("Error in sys.excepthook:", file=sys.stderr)
    fault.__context__ = None
    sys.__excepthook__(type(fault), fault.with_traceback(inner), inner)
    print("\nOriginal exception was:", file=sys.stderr)
    sys.__excepthook__(type(value), value, value.__traceback__)
