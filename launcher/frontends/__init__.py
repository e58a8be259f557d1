"""The front ends: a launch file of any kind becomes a LaunchDescription."""

from __future__ import annotations

import importlib

from launcher.frontends import python

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.description import LaunchDescription

_MARKUP = {"xml": "launcher.frontends.xml", "yaml": "launcher.frontends.yaml"}


def load(path: str) -> LaunchDescription:
    """The description in a launch file; the vocabulary must be open (language.compat).

    Raises LaunchFileError with the place in the file; its `__cause__` is what went wrong.
    """
    return python.load(path)


def load_xml(path: str) -> LaunchDescription:
    """The description in an XML launch file."""
    return _load_markup("xml", path)


def load_yaml(path: str) -> LaunchDescription:
    """The description in a YAML launch file."""
    return _load_markup("yaml", path)


def load_markup(path: str) -> LaunchDescription:
    """The description in an XML or YAML launch file; both are tried, the likely one first."""
    module: Any = importlib.import_module("launcher.frontends.parser")
    description: LaunchDescription = module.load_markup(path)
    return description


def _load_markup(kind: str, path: str) -> LaunchDescription:
    module: Any = importlib.import_module(_MARKUP[kind])
    description: LaunchDescription = module.load(path)
    return description
