"""The answer to a name that a vocabulary module does not have."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from types import FrameType
from typing import NoReturn


class NameNotProvidedError(ImportError):
    """A launch file imports a name that this launcher does not have."""

    ros_type = "ImportError"


def refuse_unknown(module: str, provided: Iterable[str]) -> Callable[[str], NoReturn]:
    """A module's `__getattr__` that says what there is instead.

    `from launch.actions import X` is an ImportError with our message. Everything else, also
    the question of the import system whether X might be a submodule, is an AttributeError.
    """
    names = sorted(name for name in provided if not name.startswith("_"))

    def __getattr__(name: str) -> NoReturn:
        if name.startswith("__") or not _is_from_import(sys._getframe(1)):
            raise AttributeError(f"module '{module}' has no attribute '{name}'", name=name)
        raise NameNotProvidedError(_message(module, name, names), name=name)

    return __getattr__


def _message(module: str, name: str, names: list[str]) -> str:
    import difflib

    near = difflib.get_close_matches(name, names, n=1)
    advice = f"did you mean {near[0]}? " if near else ""
    return (
        f"{module}.{name} is not provided by this launcher ({advice}provided: {', '.join(names)})"
    )


def _is_from_import(frame: FrameType) -> bool:
    import opcode

    return frame.f_code.co_code[frame.f_lasti] == opcode.opmap["IMPORT_FROM"]
