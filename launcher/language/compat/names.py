"""The answer to a name that a vocabulary module does not have."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable, Iterable
from types import FrameType, ModuleType
from typing import Any


class NameNotProvidedError(ImportError):
    """A launch file imports a name that this launcher does not have."""

    ros_type = "ImportError"


def refuse_unknown(module: str, provided: Iterable[str]) -> Callable[[str], Any]:
    """A module's `__getattr__` that says what there is instead.

    `from launch.actions import X` is an ImportError with our message. Everything else, also
    the question of the import system whether X might be a submodule, is an AttributeError.
    """
    names = sorted(name for name in provided if not name.startswith("_"))

    def __getattr__(name: str) -> Any:
        if not name.startswith("__") and (submodule := _submodule(module, name)) is not None:
            return submodule
        if name.startswith("__") or not _is_from_import(sys._getframe(1)):
            raise AttributeError(f"module '{module}' has no attribute '{name}'", name=name)
        raise NameNotProvidedError(_message(module, name, names), name=name)

    return __getattr__


def _submodule(module: str, name: str) -> ModuleType | None:
    """`launch.actions` after a mere `import launch`: ROS 2 imports its submodules at once."""
    if getattr(sys.modules.get(module), "__path__", None) is None:
        return None
    full_name = f"{module}.{name}"
    if importlib.util.find_spec(full_name) is None:
        return None
    return importlib.import_module(full_name)


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


def borrow(module: str, name: str) -> Any:
    """A name from a module that stands above the language, looked up when it is imported."""
    return getattr(importlib.import_module(module), name)
