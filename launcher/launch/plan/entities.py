"""Short descriptions of entities, conditions and events, for the tree of a plan."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Mapping
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
from launcher.language.ros import scope
from launcher.language.ros.parameter_descriptions import ParameterValue
from launcher.language.substitution import (
    Substitution,
    TextSubstitution,
    describe_substitutions,
    description_of,
    normalize_to_list_of_substitutions,
    plain_text,
)
from launcher.language.substitutions.configuration import LaunchConfiguration
from launcher.language.type_utils import is_substitution
from launcher.launch.plan.shell_command import shell_word

Words = Callable[[object], str]  # how substitutions are written
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


def described(parts: object, values: Mapping[str, object] | None = None) -> str:
    """Substitutions as text, with these values of launch configurations; texts without quotes."""
    subs = normalize_to_list_of_substitutions(parts)
    known = [_known(one, values or {}) for one in subs]
    text = plain_text(known)
    return describe_substitutions(known) if text is None else text


def _known(part: Substitution, values: Mapping[str, object]) -> Substitution:
    """The value of a launch configuration instead of it, if there is one."""
    name = plain_text(part.variable_name) if isinstance(part, LaunchConfiguration) else None
    value = None if name is None else values.get(name)
    return part if value is None else TextSubstitution(text=str(value))


def headline(entity: Any, values: Mapping[str, object] | None = None) -> str:
    """What an entity is, in a few words; `values` are those of launch configurations."""
    for kind, text in _HEADLINES:
        if isinstance(entity, kind):
            return str(text(entity, functools.partial(described, values=values)))
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


def _function_name(action: OpaqueFunction, of: Words) -> str:
    function = vars(action).get("_OpaqueFunction__function")
    return f"function {getattr(function, '__name__', 'of the launch file')}"


def _program(action: object, of: Words) -> str:
    package = getattr(action, "node_package", None)
    executable = getattr(action, "node_executable", None)
    if executable is not None:
        program = of(executable)
        return f"{type(action).__name__} {of(package) + '/' if package else ''}{program}"
    if isinstance(action, ExecuteProcess):
        return "process " + " ".join(of(word) for word in action.cmd)
    return type(action).__name__


def _timer(action: TimerAction, of: Words) -> str:
    period = action.period
    return f"after {period} s" if isinstance(period, float) else f"after {of(period)} s"


def _reason(reason: object, of: Words) -> str:
    return of(reason) if isinstance(reason, (Substitution, list)) else str(reason)


def _variable(action: Any, of: Words) -> str:
    return f"environment {of(action.name)} = {of(action.value)}"


def _replaced(action: settings.ReplaceEnvironmentVariables, of: Words) -> str:
    pairs = [f"{of(n)}={of(v)}" for n, v in action.environment.items()]
    return f"the environment is {' '.join(pairs) or 'empty'}"


def _parameter(action: scope.SetParameter, of: Words) -> str:
    value = action.value
    if isinstance(value, ParameterValue):
        value = value.value
    if isinstance(value, (list, tuple)):
        value = of(value) if is_substitution(value) else list(value)
    return f"parameter {of(action.name)} = {value}"


def _sim_time(action: scope.SetUseSimTime, of: Words) -> str:
    value = action.value if isinstance(action.value, bool) else of(action.value)
    return f"timers use simulated time: {value}"


_HEADLINES: tuple[tuple[type, Any], ...] = (
    (
        IncludeLaunchDescription,
        lambda a, of: f"include {short_path(a.launch_description_source.location)}",
    ),
    (DeclareLaunchArgument, lambda a, of: f"argument {a.name}"),
    (settings.SetLaunchConfiguration, lambda a, of: f"set {of(a.name)}"),
    (settings.UnsetLaunchConfiguration, lambda a, of: f"unset {of(a.name)}"),
    (settings.SetEnvironmentVariable, _variable),
    (settings.AppendEnvironmentVariable, _variable),
    (settings.ReplaceEnvironmentVariables, _replaced),
    (scope.SetParameter, _parameter),
    (scope.SetRemap, lambda a, of: f"remap {of(a.src)} to {of(a.dst)}"),
    (scope.SetUseSimTime, _sim_time),
    (settings.UnsetEnvironmentVariable, lambda a, of: f"unset environment {of(a.name)}"),
    (GroupAction, lambda a, of: "group"),
    (ForEach, lambda a, of: f"for each of {of(a.input_values) or 'nothing'}"),
    (ForLoop, lambda a, of: f"for {a.name or 'i'} from 0, {of(a.length)} times"),
    (TimerAction, _timer),
    (OpaqueFunction, _function_name),
    (Log, lambda a, of: f"log {of(a.msg)}"),
    (Shutdown, lambda a, of: f"shutdown: {_reason(a.event.reason, of)}"),
    (EmitEvent, lambda a, of: f"emit {type(a.event).__name__}"),
    (RegisterEventHandler, lambda a, of: "event handler"),
    (ExecuteLocal, _program),
)
