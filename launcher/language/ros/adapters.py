"""Parts of launch_ros for extensions. Only scripts have a ROS node in their own process."""

from __future__ import annotations

import re

from launcher.language import launch_session
from launcher.language.description import LaunchDescription
from launcher.language.events.handlers import OnShutdown
from launcher.language.naming import public, read_only

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.events.base import Event

_NO_NODE = (
    "this launcher runs a launch file without a ROS node; start a process that does the work, "
    "use the actions for services and parameters, or run a LaunchService in a script"
)


@public("launch_ros.ros_adapters")
class ROSAdapter:
    """A ROS node that a thread spins; in a launch file, which has none, a RuntimeError."""

    argv: list[str] = read_only()

    def __init__(self, *, argv: list[str] | None = None, autostart: bool = True) -> None:
        self.__argv = [] if argv is None else argv
        self.__open: launch_session.RosNode | None = None
        if autostart:
            self.start()

    def start(self) -> None:
        """Create node, context and executor; RuntimeError if there are some."""
        if self.__open is not None:
            raise RuntimeError("Cannot start a ROS adapter that is already running")
        open_ros_node = launch_session.current().open_ros_node
        if open_ros_node is None:
            raise RuntimeError(_NO_NODE)
        self.__open = open_ros_node(self.__argv)

    def shutdown(self) -> None:
        """Destroy them; RuntimeError if there are none."""
        if self.__open is None:
            raise RuntimeError("Cannot shutdown a ROS adapter that is not running")
        self.__open.close()
        self.__open = None

    @property
    def ros_context(self) -> Any:
        """The rclpy context; None if the adapter does not run, like node and executor."""
        return None if self.__open is None else self.__open.context

    @property
    def ros_node(self) -> Any:
        return None if self.__open is None else self.__open.node

    @property
    def ros_executor(self) -> Any:
        return None if self.__open is None else self.__open.executor


def get_ros_adapter(context: LaunchContext) -> ROSAdapter:
    """The adapter of this context, started if it does not run; a shutdown ends it."""
    adapter: ROSAdapter | None = getattr(context.locals, "ros_adapter", None)
    if adapter is None:
        adapter = ROSAdapter()
        context.extend_globals({"ros_adapter": adapter})
        context.register_event_handler(OnShutdown(on_shutdown=_shut_down))
    elif adapter.ros_node is None:
        adapter.start()
    return adapter


def get_ros_node(context: LaunchContext) -> Any:
    """The rclpy node of `get_ros_adapter`."""
    return get_ros_adapter(context).ros_node


def _shut_down(event: Event, context: LaunchContext) -> None:
    adapter = context.locals.ros_adapter
    if adapter.ros_node is not None:
        adapter.shutdown()


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
