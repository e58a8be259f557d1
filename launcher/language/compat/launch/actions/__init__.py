"""`launch.actions`: our vocabulary under ROS 2's name."""

from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.actions.configuration import (
    AppendEnvironmentVariable,
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    ReplaceEnvironmentVariables,
    ResetEnvironment,
    ResetLaunchConfigurations,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
    UnsetEnvironmentVariable,
    UnsetLaunchConfiguration,
)
from launcher.language.actions.coroutine import OpaqueCoroutine
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
from launcher.language.actions.logs import Log, LogDebug, LogError, LogWarning
from launcher.language.actions.loops import ForEach, ForLoop
from launcher.language.actions.process import ExecuteLocal, ExecuteProcess
from launcher.language.actions.timer import TimerAction
from launcher.language.compat.names import refuse_unknown

__all__ = [
    "AppendEnvironmentVariable",
    "DeclareLaunchArgument",
    "EmitEvent",
    "ExecuteLocal",
    "ExecuteProcess",
    "ForEach",
    "ForLoop",
    "GroupAction",
    "IncludeLaunchDescription",
    "Log",
    "LogDebug",
    "LogError",
    "LogInfo",
    "LogWarning",
    "OpaqueCoroutine",
    "OpaqueFunction",
    "PopEnvironment",
    "PopLaunchConfigurations",
    "PushEnvironment",
    "PushLaunchConfigurations",
    "RegisterEventHandler",
    "ReplaceEnvironmentVariables",
    "ResetEnvironment",
    "ResetLaunchConfigurations",
    "SetEnvironmentVariable",
    "SetLaunchConfiguration",
    "Shutdown",
    "TimerAction",
    "UnregisterEventHandler",
    "UnsetEnvironmentVariable",
    "UnsetLaunchConfiguration",
]

__getattr__ = refuse_unknown("launch.actions", __all__)
