"""Lets ament_index_python find what the launcher finds.

It searches only the prefixes of `AMENT_PREFIX_PATH`; a package that is used from its source folder
is in none of them until it has been looked up here.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import Any

MODULE = "ament_index_python.packages"
_MODULES = ("ament_index_python", MODULE)

_changed: list[tuple[ModuleType, str, Any]] = []


def extend_imported() -> None:
    """Let the modules that are imported already find these packages, too, until `restore`."""
    for name in _MODULES:
        if name in sys.modules:
            _extend(sys.modules[name])


def restore() -> None:
    while _changed:
        module, name, original = _changed.pop()
        setattr(module, name, original)


def extended_spec(path: Sequence[str] | None) -> ModuleSpec | None:
    """The spec of the module, which is extended as soon as it is imported."""
    spec = PathFinder.find_spec(MODULE, path)
    loader: Any = spec and spec.loader
    if loader is not None:
        execute = loader.exec_module

        def execute_and_extend(module: ModuleType) -> None:
            execute(module)
            _extend(module)

        loader.exec_module = execute_and_extend
    return spec


def _extend(module: ModuleType) -> None:
    for name, wrap in (
        ("get_package_prefix", _prefix_function),
        ("get_package_share_directory", _share_function),
    ):
        original = getattr(module, name, None)
        if original is not None and original.__module__ != __name__:
            _changed.append((module, name, original))
            setattr(module, name, wrap(original))


def _prefix_function(original: Callable[..., str]) -> Callable[..., str]:
    def get_package_prefix(package_name: str) -> str:
        try:
            return original(package_name)
        except (LookupError, OSError):
            return _found("package_prefix", package_name)

    return get_package_prefix


def _share_function(original: Callable[..., str]) -> Callable[..., str]:
    def get_package_share_directory(package_name: str, print_warning: bool = True) -> str:
        try:
            share = original(package_name, print_warning)
        except (LookupError, OSError):
            return _found("share_directory", package_name)
        from launcher.packages.source_packages import OVERLAY_FOLDER

        if OVERLAY_FOLDER in share:  # the source itself, as FindPackageShare has it
            return _found("share_directory", package_name)
        return share

    return get_package_share_directory


def _found(look_up: str, name: str) -> str:
    """The path; the exception of ament_index_python, with the launcher's hint."""
    from launcher.base.errors import PackageNotFoundError
    from launcher.language.ros.packages import missing
    from launcher.packages import finder  # takes long to import

    try:
        return str(getattr(finder, look_up)(name, os.environ))
    except PackageNotFoundError as error:
        raise missing(error, name) from None
