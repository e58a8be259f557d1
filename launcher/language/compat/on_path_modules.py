"""Lets programs, tests and plugins `import launch` where no `launch` is installed.

The folder `on_path` is the last entry of `sys.path`, so that every installed package goes first.
Its modules become those of `import launcher.api`, for the rest of the process.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from importlib.machinery import ModuleSpec, PathFinder

from launcher.language.compat import ON_PATH


def provide(name: str) -> None:
    """Replace the module of this name, which is being imported, by the installed or our own."""
    spec = _installed(name)
    if spec is not None and spec.loader is not None:
        sys.modules[name] = module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return
    importlib.import_module("launcher.api")
    sys.modules.pop(name, None)
    importlib.import_module(name)


def _installed(name: str) -> ModuleSpec | None:
    """The package that is found behind us: on the path, or by the finder of editable ones."""
    entries = [entry for entry in sys.path if entry != ON_PATH]
    for finder in sys.meta_path:
        spec = finder.find_spec(name, entries if finder is PathFinder else None)
        if spec is not None and spec.origin is not None:
            return spec
    return None


def extend_path() -> None:
    """Add the folder to the path of this process, if the installation has not."""
    if not any(os.path.samefile(ON_PATH, one) for one in sys.path if os.path.isdir(one)):
        sys.path.append(ON_PATH)
