"""Built-in tags and substitutions, and the parse functions of their classes.

Classes and functions are listed by module and imported when a launch file uses them. The `parse`
methods of the language's classes call these functions.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from functools import partial

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def _by_name(modules: dict[str, str]) -> dict[str, tuple[str, str]]:
    """Name in a launch file -> (module, class)."""
    return {
        name: (module, class_name)
        for module, entries in modules.items()
        for name, class_name in (entry.split("=") for entry in entries.split())
    }


ACTIONS = _by_name(
    {
        "launcher.language.actions.trace": "trace=Trace",
        "launcher.language.actions.arguments": (
            "arg=DeclareLaunchArgument bool_arg=DeclareBooleanLaunchArgument"
        ),
        "launcher.language.actions.configuration": (
            "append_env=AppendEnvironmentVariable let=SetLaunchConfiguration "
            "rep_env=ReplaceEnvironmentVariables reset=ResetLaunchConfigurations "
            "reset_env=ResetEnvironment set_env=SetEnvironmentVariable "
            "unset=UnsetLaunchConfiguration unset_env=UnsetEnvironmentVariable"
        ),
        "launcher.language.actions.event_actions": (
            "log=LogInfo log_debug=LogDebug log_error=LogError log_info=LogInfo "
            "log_warning=LogWarning shutdown=Shutdown"
        ),
        "launcher.language.actions.group": "group=GroupAction",
        "launcher.language.actions.include": "include=IncludeLaunchDescription",
        "launcher.language.actions.loops": "for=ForLoop for_each=ForEach",
        "launcher.language.actions.process": "executable=ExecuteProcess",
        "launcher.language.actions.timer": "ros_timer=RosTimer timer=TimerAction",
        "launcher.language.ros.composition": (
            "load_composable_node=LoadComposableNodes node_container=ComposableNodeContainer"
        ),
        "launcher.language.ros.lifecycle": "lifecycle_node=LifecycleNode",
        "launcher.language.ros.node": "node=Node",
        "launcher.language.ros.scope": (
            "push-ros-namespace=PushROSNamespace push_ros_namespace=PushROSNamespace "
            "set_parameter=SetParameter set_parameters_from_file=SetParametersFromFile "
            "set_remap=SetRemap set_ros_log_dir=SetROSLogDir set_use_sim_time=SetUseSimTime"
        ),
    }
)

SUBSTITUTIONS = _by_name(
    {
        "launcher.language.ros.packages": (
            "exec-in-pkg=ExecutableInPackage find-pkg-prefix=FindPackagePrefix "
            "find-pkg-share=FindPackageShare"
        ),
        "launcher.language.ros.scope": "param=Parameter",
        "launcher.language.substitutions.command": "command=Command",
        "launcher.language.substitutions.configuration": (
            "env=EnvironmentVariable var=LaunchConfiguration"
        ),
        "launcher.language.substitutions.files": (
            "dirname=ThisLaunchFileDir file-content=FileContent filename=ThisLaunchFile "
            "find-exec=FindExecutable launch_log_dir=LaunchLogDir log_dir=LaunchLogDir "
            "path-join=PathJoinSubstitution"
        ),
        "launcher.language.substitutions.logic": (
            "all=AllSubstitution and=AndSubstitution any=AnySubstitution "
            "equals=EqualsSubstitution if=IfElseSubstitution not=NotSubstitution "
            "not-equals=NotEqualsSubstitution or=OrSubstitution"
        ),
        "launcher.language.substitutions.anon_name": "anon=AnonName",
        "launcher.language.substitutions.for_loop_var": "for-var=ForEachVar index=ForLoopIndex",
        "launcher.language.substitutions.python": "eval=PythonExpression",
        "launcher.language.substitutions.text": "string-join=StringJoinSubstitution",
    }
)

# Newer than Jazzy, or of a package: one that exposes its own takes precedence.
NEWER = {
    *("bool_arg", "for", "for_each", "lifecycle_node", "rep_env", "trace"),
    *("log_debug", "log_error", "log_info", "log_warning"),
    *("for-var", "index", "path-join", "string-join"),
}

_ACTIONS = "launcher.language.frontends.parsers.actions"
_NODES = "launcher.language.frontends.parsers.nodes"
_PROCESS = "launcher.language.frontends.parsers.process"
_SUBSTITUTIONS = "launcher.language.frontends.parsers.substitutions"

# Class, or class and purpose -> (module, function).
_PARSE_FUNCTIONS = {
    "AppendEnvironmentVariable": (_ACTIONS, "parse_append"),
    "ComposableLifecycleNode": (_NODES, "parse_composable_lifecycle_node"),
    "ComposableNode": (_NODES, "parse_composable_node"),
    "ComposableNodeContainer": (_NODES, "parse_container"),
    "DeclareBooleanLaunchArgument": (_ACTIONS, "parse_boolean_argument"),
    "DeclareLaunchArgument": (_ACTIONS, "parse_argument"),
    "ExecuteProcess": (_PROCESS, "parse_process"),
    "ExecuteProcess.cmdline": (_PROCESS, "parse_words"),
    "ForEach": (_ACTIONS, "parse_for_each"),
    "ForLoop": (_ACTIONS, "parse_for"),
    "GroupAction": (_ACTIONS, "parse_group"),
    "IncludeLaunchDescription": (_ACTIONS, "parse_include"),
    "LifecycleNode": (_NODES, "parse_lifecycle_node"),
    "LoadComposableNodes": (_NODES, "parse_load"),
    "LogInfo": (_ACTIONS, "parse_log"),
    "Node": (_NODES, "parse_node"),
    "Node.parameters": (_NODES, "parse_parameters"),
    "ReplaceEnvironmentVariables": (_ACTIONS, "parse_environment"),
    "ResetLaunchConfigurations": (_ACTIONS, "parse_reset"),
    "RosTimer": (_ACTIONS, "parse_timer"),
    "SetUseSimTime": (_NODES, "parse_use_sim_time"),
    "Shutdown": (_ACTIONS, "parse_shutdown"),
    "Substitution": (_SUBSTITUTIONS, "parse_substitution"),
    "TimerAction": (_ACTIONS, "parse_timer"),
    "Trace": (_ACTIONS, "parse_trace"),
}

# Actions whose attributes are all required texts: keyword of the constructor -> attribute.
_TEXTS = {
    "Action": {},
    "Log": {"msg": "message"},
    "PopEnvironment": {},
    "PopLaunchConfigurations": {},
    "PushEnvironment": {},
    "PushLaunchConfigurations": {},
    "PushROSNamespace": {"namespace": "namespace"},
    "ResetEnvironment": {},
    "SetEnvironmentVariable": {"name": "name", "value": "value"},
    "SetLaunchConfiguration": {"name": "name", "value": "value"},
    "SetParameter": {"name": "name", "value": "value"},
    "SetParametersFromFile": {"filename": "filename"},
    "SetROSLogDir": {"new_log_dir": "new_log_dir"},
    "SetRemap": {"src": "from", "dst": "to"},
    "UnsetEnvironmentVariable": {"name": "name"},
    "UnsetLaunchConfiguration": {"name": "name"},
}


def builtin_action(tag: str) -> Callable[..., Any] | None:
    """The `parse` method of the action behind a tag; None if it is not built in."""
    return _parse_method(ACTIONS.get(tag))


def builtin_substitution(name: str) -> Callable[..., Any] | None:
    """The parse function of a substitution; None if it is not built in."""
    return _parse_method(SUBSTITUTIONS.get(name))


def _parse_method(entry: tuple[str, str] | None) -> Callable[..., Any] | None:
    if entry is None:
        return None
    module, class_name = entry
    owner = getattr(importlib.import_module(module), class_name)
    method: Callable[..., Any] = owner.parse
    return method


def parse_function(key: str) -> Callable[..., Any]:
    """The parse function for a key of the tables above."""
    if key in _TEXTS:
        from launcher.language.frontends.parsers.attributes import parse_texts

        return partial(parse_texts, attributes=_TEXTS[key])
    module, function = _PARSE_FUNCTIONS[key]
    parse: Callable[..., Any] = getattr(importlib.import_module(module), function)
    return parse
