"""`launch.actions`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "AppendEnvironmentVariable": "launcher.language.actions.configuration",
    "DeclareLaunchArgument": "launcher.language.actions.arguments",
    "EmitEvent": "launcher.language.actions.events",
    "ExecuteLocal": "launcher.language.actions.process",
    "ExecuteProcess": "launcher.language.actions.process",
    "ForEach": "launcher.language.actions.loops",
    "ForLoop": "launcher.language.actions.loops",
    "GroupAction": "launcher.language.actions.group",
    "IncludeLaunchDescription": "launcher.language.actions.include",
    "Log": "launcher.language.actions.logs",
    "LogDebug": "launcher.language.actions.logs",
    "LogError": "launcher.language.actions.logs",
    "LogInfo": "launcher.language.actions.events",
    "LogWarning": "launcher.language.actions.logs",
    "OpaqueCoroutine": "launcher.language.actions.coroutine",
    "OpaqueFunction": "launcher.language.actions.events",
    "PopEnvironment": "launcher.language.actions.configuration",
    "PopLaunchConfigurations": "launcher.language.actions.configuration",
    "PushEnvironment": "launcher.language.actions.configuration",
    "PushLaunchConfigurations": "launcher.language.actions.configuration",
    "RegisterEventHandler": "launcher.language.actions.events",
    "ReplaceEnvironmentVariables": "launcher.language.actions.configuration",
    "ResetEnvironment": "launcher.language.actions.configuration",
    "ResetLaunchConfigurations": "launcher.language.actions.configuration",
    "SetEnvironmentVariable": "launcher.language.actions.configuration",
    "SetLaunchConfiguration": "launcher.language.actions.configuration",
    "Shutdown": "launcher.language.actions.events",
    "TimerAction": "launcher.language.actions.timer",
    "UnregisterEventHandler": "launcher.language.actions.events",
    "UnsetEnvironmentVariable": "launcher.language.actions.configuration",
    "UnsetLaunchConfiguration": "launcher.language.actions.configuration",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
