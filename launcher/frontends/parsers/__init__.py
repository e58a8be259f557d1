"""The tables of tags and substitutions, and of what parses them.

Classes and parse functions are named by module, and imported when they turn up in a launch file.
The `parse` methods of the language's classes end up here.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

# Tag -> (module below launcher.language, class).
ACTIONS = {
    "append_env": ("actions.configuration", "AppendEnvironmentVariable"),
    "arg": ("actions.arguments", "DeclareLaunchArgument"),
    "executable": ("actions.process", "ExecuteProcess"),
    "for": ("actions.loops", "ForLoop"),
    "for_each": ("actions.loops", "ForEach"),
    "group": ("actions.group", "GroupAction"),
    "include": ("actions.include", "IncludeLaunchDescription"),
    "lifecycle_node": ("ros.lifecycle", "LifecycleNode"),
    "let": ("actions.configuration", "SetLaunchConfiguration"),
    "load_composable_node": ("ros.composition", "LoadComposableNodes"),
    "log": ("actions.events", "LogInfo"),
    "log_debug": ("actions.logs", "LogDebug"),
    "log_error": ("actions.logs", "LogError"),
    "log_info": ("actions.events", "LogInfo"),
    "log_warning": ("actions.logs", "LogWarning"),
    "node": ("ros.node", "Node"),
    "node_container": ("ros.composition", "ComposableNodeContainer"),
    "push-ros-namespace": ("ros.scope", "PushROSNamespace"),
    "push_ros_namespace": ("ros.scope", "PushROSNamespace"),
    "rep_env": ("actions.configuration", "ReplaceEnvironmentVariables"),
    "reset": ("actions.configuration", "ResetLaunchConfigurations"),
    "reset_env": ("actions.configuration", "ResetEnvironment"),
    "ros_timer": ("actions.timer", "RosTimer"),
    "set_env": ("actions.configuration", "SetEnvironmentVariable"),
    "set_parameter": ("ros.scope", "SetParameter"),
    "set_parameters_from_file": ("ros.scope", "SetParametersFromFile"),
    "set_remap": ("ros.scope", "SetRemap"),
    "set_ros_log_dir": ("ros.scope", "SetROSLogDir"),
    "set_use_sim_time": ("ros.scope", "SetUseSimTime"),
    "shutdown": ("actions.events", "Shutdown"),
    "timer": ("actions.timer", "TimerAction"),
    "unset": ("actions.configuration", "UnsetLaunchConfiguration"),
    "unset_env": ("actions.configuration", "UnsetEnvironmentVariable"),
}

# Name of `$(name ...)` -> (module below launcher.language, class).
SUBSTITUTIONS = {
    "all": ("substitutions.logic", "AllSubstitution"),
    "and": ("substitutions.logic", "AndSubstitution"),
    "anon": ("substitutions.names", "AnonName"),
    "any": ("substitutions.logic", "AnySubstitution"),
    "command": ("substitutions.command", "Command"),
    "dirname": ("substitutions.files", "ThisLaunchFileDir"),
    "env": ("substitutions.environment", "EnvironmentVariable"),
    "equals": ("substitutions.logic", "EqualsSubstitution"),
    "eval": ("substitutions.python", "PythonExpression"),
    "exec-in-pkg": ("ros.packages", "ExecutableInPackage"),
    "file-content": ("substitutions.files", "FileContent"),
    "filename": ("substitutions.files", "ThisLaunchFile"),
    "find-exec": ("substitutions.files", "FindExecutable"),
    "find-pkg-prefix": ("ros.packages", "FindPackagePrefix"),
    "find-pkg-share": ("ros.packages", "FindPackageShare"),
    "for-var": ("substitutions.names", "ForEachVar"),
    "if": ("substitutions.logic", "IfElseSubstitution"),
    "index": ("substitutions.names", "ForLoopIndex"),
    "launch_log_dir": ("substitutions.files", "LaunchLogDir"),
    "log_dir": ("substitutions.files", "LaunchLogDir"),
    "not": ("substitutions.logic", "NotSubstitution"),
    "not-equals": ("substitutions.logic", "NotEqualsSubstitution"),
    "or": ("substitutions.logic", "OrSubstitution"),
    "param": ("ros.scope", "Parameter"),
    "path-join": ("substitutions.files", "PathJoinSubstitution"),
    "string-join": ("substitutions.text", "StringJoinSubstitution"),
    "var": ("substitutions.configuration", "LaunchConfiguration"),
}

# Names that came after Jazzy: packages made for Jazzy may have exposed their own, which count then.
NEWER = {
    *("for", "for_each", "lifecycle_node", "rep_env"),
    *("log_debug", "log_error", "log_info", "log_warning"),
    *("for-var", "index", "path-join", "string-join"),
}

# Class, or another name that the language asks for -> (module of this package, function).
_PARSE_FUNCTIONS = {
    "Action": ("base", "parse_action"),
    "AppendEnvironmentVariable": ("environment", "parse_append"),
    "ComposableNode": ("composition", "parse_composable_node"),
    "ComposableNodeContainer": ("composition", "parse_container"),
    "DeclareLaunchArgument": ("arguments", "parse_argument"),
    "ExecuteProcess": ("process", "parse_process"),
    "ExecuteProcess.cmdline": ("process", "parse_words"),
    "ForEach": ("newer", "parse_for_each"),
    "ForLoop": ("newer", "parse_for"),
    "GroupAction": ("groups", "parse_group"),
    "IncludeLaunchDescription": ("includes", "parse_include"),
    "LifecycleNode": ("node", "parse_lifecycle_node"),
    "LoadComposableNodes": ("composition", "parse_load"),
    "Log": ("newer", "parse_log"),
    "LogInfo": ("events", "parse_log"),
    "Node": ("node", "parse_node"),
    "Node.parameters": ("node", "parse_parameters"),
    "PopEnvironment": ("base", "parse_action"),
    "PopLaunchConfigurations": ("base", "parse_action"),
    "PushEnvironment": ("base", "parse_action"),
    "PushLaunchConfigurations": ("base", "parse_action"),
    "PushROSNamespace": ("ros_scope", "parse_namespace"),
    "ReplaceEnvironmentVariables": ("newer", "parse_environment"),
    "ResetEnvironment": ("base", "parse_action"),
    "ResetLaunchConfigurations": ("groups", "parse_reset"),
    "RosTimer": ("groups", "parse_timer"),
    "SetEnvironmentVariable": ("environment", "parse_set"),
    "SetLaunchConfiguration": ("arguments", "parse_let"),
    "SetParameter": ("ros_scope", "parse_set_parameter"),
    "SetParametersFromFile": ("ros_scope", "parse_parameters_from_file"),
    "SetROSLogDir": ("ros_scope", "parse_log_dir"),
    "SetRemap": ("ros_scope", "parse_remap"),
    "SetUseSimTime": ("ros_scope", "parse_use_sim_time"),
    "Shutdown": ("events", "parse_shutdown"),
    "Substitution": ("substitutions", "parse_substitution"),
    "parse_substitution": ("substitutions", "parse_template"),
    "TimerAction": ("groups", "parse_timer"),
    "UnsetEnvironmentVariable": ("environment", "parse_unset"),
    "UnsetLaunchConfiguration": ("arguments", "parse_unset"),
}


def builtin_action(tag: str) -> Callable[..., Any] | None:
    """The `parse` method of the action behind a tag; None if it is no tag of ours."""
    return _parse_method(ACTIONS.get(tag))


def builtin_substitution(name: str) -> Callable[..., Any] | None:
    """The parse function of a substitution; None if it is none of ours."""
    return _parse_method(SUBSTITUTIONS.get(name))


def _parse_method(entry: tuple[str, str] | None) -> Callable[..., Any] | None:
    if entry is None:
        return None
    module, class_name = entry
    owner = getattr(importlib.import_module(f"launcher.language.{module}"), class_name)
    method: Callable[..., Any] = owner.parse
    return method


def parse_function(key: str) -> Callable[..., Any]:
    """The parse function of a class of the language, or for another purpose."""
    module, function = _PARSE_FUNCTIONS[key]
    parse: Callable[..., Any] = getattr(importlib.import_module(f"{__name__}.{module}"), function)
    return parse
