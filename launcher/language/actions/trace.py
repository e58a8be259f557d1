"""Trace: an action for tracing, which launch files may hold and a run leaves out."""

from __future__ import annotations

from launcher.language.action import Action
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("tracetools_launch.action")
@parsed
class Trace(Action):
    """Would trace the launch with LTTng; takes any arguments, and warns."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(condition=kwargs.get("condition"))

    def execute(self, context: LaunchContext) -> None:
        advice = "start `ros2 trace` of an installed ROS 2 beside the launch"
        text = f"Trace is left out: tracing needs LTTng; {advice}"
        context._host.warn_quirk(text, self._origin)
