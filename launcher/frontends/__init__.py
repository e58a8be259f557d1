"""The front ends: a launch file of any kind becomes a LaunchDescription."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from launcher.frontends import python

if TYPE_CHECKING:
    from launcher.language.description import LaunchDescription

_MARKUP = {"xml": "launcher.frontends.xml", "yaml": "launcher.frontends.yaml"}
_KINDS = {".xml": "xml", ".yaml": "yaml", ".yml": "yaml"}


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
    """The description in an XML or YAML launch file; without a known ending both are tried."""
    ending = "." + path.rpartition("/")[2].rpartition(".")[2]
    if ending in _KINDS:
        return _load_markup(_KINDS[ending], path)
    try:
        return load_xml(path)
    except FileNotFoundError:
        raise
    except Exception as xml_error:
        try:
            return load_yaml(path)
        except Exception:
            raise xml_error from None


def _load_markup(kind: str, path: str) -> LaunchDescription:
    module: Any = importlib.import_module(_MARKUP[kind])
    description: LaunchDescription = getattr(module, f"load_{kind}")(path)
    return description
