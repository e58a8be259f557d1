"""The generated Python classes of types, and what they need: other packages and libraries."""

from __future__ import annotations

import importlib
import os
import re
import sys
from collections.abc import Iterator
from typing import Any

from launcher.base.ros_errors import VerbError
from launcher.packages import unbuilt

_PARTS = ("Request", "Response", "Goal", "Result", "Feedback")
_LIBRARY = re.compile(r"\blib(\w+?)__rosidl_\w+\.so\b")


def class_of(package: str, kind: str, name: str) -> Any:
    """A generated class; ModuleNotFoundError, AttributeError.

    `pkg.action` has `Fold`, but not all that the topics and services of an action use, such as
    `Fold_FeedbackMessage`: these are in the module of `Fold`.
    """
    module = importlib.import_module(f"{package}.{kind}")
    if not hasattr(module, name) and "_" in name:
        module = sys.modules[getattr(module, name.partition("_")[0]).__module__]
    return getattr(module, name)


def parts_of(package: str, kind: str, name: str) -> list[str]:
    """The names of the classes of which a service or action is made; none if it is not there."""
    whole = name.partition("_")[0]
    try:
        module = sys.modules[class_of(package, kind, whole).__module__]
    except (ModuleNotFoundError, AttributeError, ValueError):
        return []
    return sorted(one for one in vars(module) if one.startswith(f"{whole}_"))


def missing_package(full: str, package: str) -> VerbError:
    return VerbError(
        f"{full} needs the package '{package}', which is not installed",
        hint=unbuilt.hint(package, os.environ),
    )


def check_fields(cls: object) -> None:
    """VerbError if the package of a field is not installed.

    Generated classes import it only when a message is made.
    """
    checked: set[tuple[str, str, str]] = set()
    open_ = [cls, *(getattr(cls, part) for part in _PARTS if hasattr(cls, part))]
    while open_:
        owner = open_.pop()
        for package, kind, name in _types_of_fields(owner):
            if (package, kind, name) not in checked:
                checked.add((package, kind, name))
                try:
                    open_.append(class_of(package, kind, name))
                except ModuleNotFoundError as error:
                    if error.name not in (package, f"{package}.{kind}"):
                        raise
                    raise missing_package(type_name(owner), package) from None
                except AttributeError:
                    needed = f"{package}/{kind}/{name}"
                    raise VerbError(
                        f"{type_name(owner)} needs {needed}, which is not installed"
                    ) from None


def _types_of_fields(cls: object) -> Iterator[tuple[str, str, str]]:
    for slot in getattr(cls, "SLOT_TYPES", ()):
        kind = getattr(slot, "value_type", slot)  # that of the elements of an array
        if hasattr(kind, "namespaced_name"):
            package, folder, name = kind.namespaced_name()
            yield package, folder, name


def with_library(cls: object) -> Any:
    """The class, ready to be sent and received; VerbError with what cannot be loaded."""
    from rclpy.type_support import check_for_type_support
    from rosidl_generator_py.import_type_support_impl import UnsupportedTypeSupport

    from launcher.packages.extras import is_installed

    try:
        check_for_type_support(cls)
    except UnsupportedTypeSupport as error:
        reason = str(error.__context__ or error)
        library = _LIBRARY.search(reason)
        if library and not is_installed(library[1]):
            raise missing_package(type_name(cls), library[1]) from None
        raise VerbError(
            f"the library of {type_name(cls)} cannot be loaded: {reason}",
            hint=unbuilt.hint(error.pkg_name, os.environ),
        ) from None
    return cls


def type_name(cls: Any) -> str:
    return "/".join([*cls.__module__.split(".")[:2], cls.__name__])
