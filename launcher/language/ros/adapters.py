"""Parts of launch_ros for extensions. The launcher has no ROS node in its own process."""

from __future__ import annotations

import re

from launcher.language.description import LaunchDescription
from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn


@public("launch_ros.ros_adapters")
class ROSAdapter:
    """RuntimeError when constructed."""

    def __init__(self, *, argv: Any = None, autostart: bool = True) -> None:
        _refuse()


def get_ros_adapter(context: Any) -> NoReturn:
    """RuntimeError, like ROSAdapter."""
    _refuse()


def get_ros_node(context: Any) -> NoReturn:
    """RuntimeError, like ROSAdapter."""
    _refuse()


def _refuse() -> NoReturn:
    raise RuntimeError(
        "this launcher has no ROS node of its own; "
        "start a process that does the work, or use the actions for services and parameters"
    )


def get_default_launch_description() -> LaunchDescription:
    """An empty description: nothing has to be set up."""
    return LaunchDescription([])


@public("launch_ros.utilities.plugin_support")
class PluginException(Exception):
    """The version of a plug-in is not supported."""


def satisfies_version(version: str, caret_range: str) -> None:
    """PluginException unless `version` fits a range like `^0.1`: same major, not older."""
    if not caret_range.startswith("^"):
        raise ValueError("only caret ranges are supported, like ^0.1")
    wanted, given = (_numbers(text) for text in (caret_range[1:], version))
    if given[0] != wanted[0] or given < wanted:
        raise PluginException(f"version {version} does not satisfy {caret_range}")


def _numbers(text: str) -> list[int]:
    if not re.fullmatch(r"\d+(\.\d+){0,2}", text):
        raise ValueError(f"'{text}' is not a version number")
    return [int(part) for part in text.split(".")]
