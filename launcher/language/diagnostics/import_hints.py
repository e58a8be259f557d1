"""Hints for names that a launch file imports from the wrong module, or does not import."""

from __future__ import annotations

import importlib
import os
import re

from launcher.base.text import did_you_mean, suggest
from launcher.language.diagnostics.proposed_names import of_module, of_python

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator

_TOP_NAMES = ("launch", "launch_ros")
# Modules that launch files import from, the most usual one of a name first.
_MODULES = (
    "launch",
    "launch.actions",
    "launch.conditions",
    "launch.substitutions",
    "launch.event_handlers",
    "launch.launch_description_sources",
    "launch.events",
    "launch_ros.actions",
    "launch_ros.substitutions",
    "launch_ros.descriptions",
    "launch_ros.parameter_descriptions",
    "launch_ros.event_handlers",
    "ament_index_python.packages",
)
_NOT_IN_MODULE = re.compile(r"^module '(launch\w*(?:\.\w+)*)' has no attribute '(\w+)'")
_NOT_PROVIDED = re.compile(r"^(launch[\w.]*)\.(\w+) is not provided")


def hint(error: BaseException, message: str) -> str | None:
    """Where the name is that an import, or a use of it, did not find."""
    if isinstance(error, ModuleNotFoundError) and error.name:
        from launcher.packages import absent_ros, unbuilt

        package = error.name.partition(".")[0]
        origin = unbuilt.hint(package, os.environ) or absent_ros.hint_for(package)
        return origin or _module_hint(error.name)
    if isinstance(error, NameError) and not isinstance(error, UnboundLocalError):
        name = getattr(error, "name", None) or ""
        return of_python(name) or _from_import(name) or _near_name(name)
    found = _NOT_PROVIDED.search(message) or _NOT_IN_MODULE.search(str(error))
    return None if found is None else of_python(found[2]) or _from_import(found[2])


def _near_name(name: str) -> str | None:
    """The class that a misspelt name was meant to be."""
    if not name[:1].isupper():
        return None
    return did_you_mean(name, {one for module in _MODULES for one in _names_of(module)})


def _from_import(name: str) -> str | None:
    for module in _MODULES:
        if name in _names_of(module):
            return f"write 'from {module} import {name}'"
    return None


def _names_of(module: str) -> tuple[str, ...]:
    try:
        return tuple(getattr(importlib.import_module(module), "__all__", ()))
    except ImportError:  # without the vocabulary, or not installed
        return ()


def _module_hint(name: str) -> str:
    package, _, last = name.rpartition(".")
    if package.partition(".")[0] in _TOP_NAMES:
        written = _from_import(last)
        near = suggest(name, list(_known_modules()))
        if of_module(last) is not None or written is not None:
            return of_module(last) or str(written)
        if near is not None:
            return f"did you mean '{near}'?"
    top = name.partition(".")[0]
    near = did_you_mean(top, _importable(top))
    return near or f"install the Python package that has {name}, or add it to PYTHONPATH"


def _importable(name: str) -> list[str]:
    """Modules that may be meant by a name: private ones, and the launcher, are not."""
    import pkgutil

    found = [module.name for module in pkgutil.iter_modules()]
    public = [one for one in found if one != "launcher" and not one.startswith("_")]
    return [*_TOP_NAMES, *(found if name.startswith("_") else public)]


def _known_modules() -> Iterator[str]:
    import pkgutil

    for top in _TOP_NAMES:
        path = getattr(importlib.import_module(top), "__path__", ())
        for module in pkgutil.iter_modules(path, f"{top}."):
            yield module.name
