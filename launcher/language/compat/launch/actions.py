"""Re-exports of `launch.actions`."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.actions.configuration import SetEnvironmentVariable, SetLaunchConfiguration
from launcher.language.actions.events import (
    EmitEvent,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
    UnregisterEventHandler,
)
from launcher.language.actions.group import GroupAction
from launcher.language.actions.include import IncludeLaunchDescription
from launcher.language.actions.process import ExecuteLocal, ExecuteProcess
from launcher.language.actions.timer import TimerAction

__all__ = [
    "DeclareLaunchArgument",
    "EmitEvent",
    "ExecuteLocal",
    "ExecuteProcess",
    "GroupAction",
    "IncludeLaunchDescription",
    "LogInfo",
    "OpaqueFunction",
    "RegisterEventHandler",
    "SetEnvironmentVariable",
    "SetLaunchConfiguration",
    "Shutdown",
    "TimerAction",
    "UnregisterEventHandler",
]

__getattr__ = refuse_unknown("launch.actions", __all__)
