"""Names of the vocabulary: looked up when asked for, and what is said when one is unknown."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable, Mapping
from types import FrameType, ModuleType

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


class NameNotProvidedError(ImportError):
    """A launch file imports a name that this launcher does not have."""

    ros_type = "ImportError"


def reexport(module: str, sources: Mapping[str, str]) -> Callable[[str], Any]:
    """A module's `__getattr__`: each name comes from `sources[name]`, as `module[:other name]`.

    A source is imported when one of its names is first asked for: a launch file pays for what
    it uses. A name that is a submodule is that submodule, as after ROS 2's own `import launch`.
    For an unknown name `from launch.actions import X` is an ImportError with our message;
    everything else, also the import system's question whether X is a submodule, is an
    AttributeError.
    """

    def __getattr__(name: str) -> Any:
        if name in sources:
            value = _fetch(name, sources[name])
            setattr(sys.modules[module], name, value)
            return value
        if not name.startswith("__"):
            submodule = _submodule(module, name)
            if submodule is not None:
                return submodule
            if _is_from_import(sys._getframe(1)):
                raise NameNotProvidedError(_message(module, name, sorted(sources)), name=name)
        raise AttributeError(f"module '{module}' has no attribute '{name}'")

    return __getattr__


def _fetch(name: str, source: str) -> Any:
    path, _, original = source.partition(":")
    return getattr(importlib.import_module(path), original or name)


def _submodule(module: str, name: str) -> ModuleType | None:
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
