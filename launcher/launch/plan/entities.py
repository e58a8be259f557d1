"""Short descriptions of entities, conditions and events, for the tree of a plan."""

from __future__ import annotations

import os
from typing import Any

from launcher.base.text import shown_path
from launcher.language.action import Action
from launcher.language.actions import configuration as settings
from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.actions.event_actions import (
    EmitEvent,
    Log,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
)
from launcher.language.actions.group import GroupAction
from launcher.language.actions.include import IncludeLaunchDescription
from launcher.language.actions.loops import ForEach, ForLoop
from launcher.language.actions.process import ExecuteLocal, ExecuteProcess
from launcher.language.actions.timer import TimerAction
from launcher.language.conditions import IfCondition, LaunchConfigurationEquals, UnlessCondition
from launcher.language.conditions import LaunchConfigurationNotEquals as NotEquals
from launcher.language.events import process as process_events
from launcher.language.substitution import (
    Substitution,
    describe_substitutions,
    description_of,
    normalize_to_list_of_substitutions,
    plain_text,
)
from launcher.launch.plan.shell_command import shell_word

_HAPPENINGS = {
    "ProcessExited": "exits",
    "ProcessStarted": "starts",
    "ProcessIO": "writes",
    "ProcessStdout": "writes to stdout",
    "ProcessStderr": "writes to stderr",
    "ExecutionComplete": "is complete",
    "StateTransition": "changes its state",
}
_WAITS = {
    "OnShutdown": "on shutdown",
    "OnStateTransition": "when a lifecycle node changes its state",
}


def place(origin: Any) -> str:
    """`file:line`, as `short_path`; empty without an origin."""
    return "" if origin is None else f"{short_path(origin.path)}:{origin.line}"


def short_path(path: str) -> str:
    """The path, relative if it is below the working directory; quoted if not printable."""
    path, here = shown_path(path), os.getcwd() + os.sep
    short = path[len(here) :] if path.startswith(here) else path
    return short if short.isprintable() else shell_word(short)


def described(parts: object) -> str:
    """Substitutions as text; plain texts without quotes."""
    subs = normalize_to_list_of_substitutions(parts)
    text = plain_text(subs)
    return describe_substitutions(subs) if text is None else text


def headline(entity: Any) -> str:
    for kind, text in _HEADLINES:
        if isinstance(entity, kind):
            return str(text(entity))
    return type(entity).__name__


def condition_text(condition: object) -> str:
    """`if ...` or `unless ...`."""
    if isinstance(condition, (IfCondition, UnlessCondition)):
        word = "if" if isinstance(condition, IfCondition) else "unless"
        return f"{word} {described(condition.predicate_expression)}"
    if isinstance(condition, LaunchConfigurationEquals):
        sign = "!=" if isinstance(condition, NotEquals) else "=="
        expected = condition.expected_value
        value = "None" if expected is None else repr(described(expected))
        return f"if {condition.launch_configuration_name} {sign} {value}"
    return f"if {description_of(condition)}"


def happening(event: Any) -> str:
    """`exits`, `starts` and so on, of the process or action that an event is about."""
    name = type(event).__name__
    if name == "StateTransition":
        return f"goes from {event.start_state} to {event.goal_state}"
    return _HAPPENINGS.get(name, f"has event {name}")


def handler_target(handler: Any) -> tuple[Any, str]:
    """(action that a handler watches or None, what it waits for)."""
    target = vars(handler).get("_OnActionEventBase__action_matcher")
    event = vars(handler).get("_OnActionEventBase__target_event_cls")
    if event is None:
        name = type(handler).__name__
        return None, _WAITS.get(name, f"event handler {name}")
    verb = _HAPPENINGS.get(event.__name__, f"has event {event.__name__}")
    if target is None or not isinstance(target, Action):
        noun = "process" if issubclass(event, process_events.RunningProcessEvent) else "action"
        which = "any" if target is None else "a matching"
        return None, f"when {which} {noun} {verb}"
    return target, verb


def handler_entities(handler: Any) -> list[Any]:
    """Entities of a handler that are known before it is called."""
    entities = list(handler.describe()[1])
    at_shutdown = vars(handler).get("_OnShutdown__on_shutdown")
    if isinstance(at_shutdown, (list, tuple)):
        entities += at_shutdown
    return entities


def _function_name(action: OpaqueFunction) -> str:
    function = vars(action).get("_OpaqueFunction__function")
    return f"function {getattr(function, '__name__', 'of the launch file')}"


def _program(action: object) -> str:
    package = getattr(action, "node_package", None)
    executable = getattr(action, "node_executable", None)
    if executable is not None:
        program = described(executable)
        return f"{type(action).__name__} {described(package) + '/' if package else ''}{program}"
    if isinstance(action, ExecuteProcess):
        return "process " + " ".join(described(word) for word in action.cmd)
    return type(action).__name__


def _timer(action: TimerAction) -> str:
    period = action.period
    return f"after {period} s" if isinstance(period, float) else f"after {described(period)} s"


def _reason(reason: object) -> str:
    return described(reason) if isinstance(reason, (Substitution, list)) else str(reason)


def _variable(action: Any) -> str:
    return f"environment {described(action.name)} = {described(action.value)}"


_HEADLINES: tuple[tuple[type, Any], ...] = (
    (
        IncludeLaunchDescription,
        lambda a: f"include {short_path(a.launch_description_source.location)}",
    ),
    (DeclareLaunchArgument, lambda a: f"argument {a.name}"),
    (settings.SetLaunchConfiguration, lambda a: f"set {described(a.name)}"),
    (settings.UnsetLaunchConfiguration, lambda a: f"unset {described(a.name)}"),
    (settings.SetEnvironmentVariable, _variable),
    (settings.AppendEnvironmentVariable, _variable),
    (settings.UnsetEnvironmentVariable, lambda a: f"unset environment {described(a.name)}"),
    (GroupAction, lambda a: "group"),
    (ForEach, lambda a: f"for each of {described(a.input_values) or 'nothing'}"),
    (ForLoop, lambda a: f"for {a.name or 'i'} from 0, {described(a.length)} times"),
    (TimerAction, _timer),
    (OpaqueFunction, _function_name),
    (Log, lambda a: f"log {described(a.msg)}"),
    (Shutdown, lambda a: f"shutdown: {_reason(a.event.reason)}"),
    (EmitEvent, lambda a: f"emit {type(a.event).__name__}"),
    (RegisterEventHandler, lambda a: "event handler"),
    (ExecuteLocal, _program),
)
