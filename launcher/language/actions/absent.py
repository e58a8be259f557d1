"""Actions of packages for tests and tracing, which launch files may hold and a run leaves out."""

from __future__ import annotations

from launcher.language.action import Action
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


class _Absent(Action):
    """Base of actions that only warn."""

    _reason = ""

    def __init__(self, **kwargs: Any) -> None:
        names = ("condition",)
        super().__init__(**{name: kwargs[name] for name in names if name in kwargs})

    def execute(self, context: LaunchContext) -> None:
        context._host.warn_quirk(f"{type(self).__name__} is left out: {self._reason}", self._origin)


@public("tracetools_launch.action")
@parsed
class Trace(_Absent):
    """Would trace the launch with LTTng; takes any arguments."""

    _reason = "tracing needs LTTng; start `ros2 trace` of an installed ROS 2 beside the launch"


@public("launch_testing_ros.actions.enable_rmw_isolation")
class EnableRmwIsolation(_Absent):
    """Would separate the nodes of a test from all others."""

    _reason = "start the launch with --private, which gives it a ROS domain of its own"
