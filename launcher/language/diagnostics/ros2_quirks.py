"""Warnings about surprising behaviour of ROS 2 that this launcher reproduces."""

from __future__ import annotations

import os

from launcher.base.text import suggest

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.context import LaunchContext
    from launcher.language.diagnostics.origin import FileLine

_SIM_TIME = "_is_on_sim_time"  # attribute of the context
_MARKUP = {
    "ThisLaunchFile()": "$(filename)",
    "ThisLaunchFileDir()": "$(dirname)",
    "SetParameter": "<set_parameter>",
    "SetParametersFromFile": "<set_parameters_from_file>",
    "SetRemap": "<set_remap>",
    "SetUseSimTime": "<set_use_sim_time>",
}


def _written(name: str, origin: FileLine | None) -> str:
    """What the launch file calls it, in Python or in XML and YAML."""
    return name if origin is None or origin.is_python else _MARKUP.get(name, name)


def scope_is_lost(context: LaunchContext, origin: FileLine | None) -> None:
    """An event handler in a scoped group, or in a timer, runs its actions outside of that scope."""
    if origin is None:
        return  # one of an action, which needs none of it
    lost = context._lost_later()
    if lost:
        text = "the actions of this event handler run outside of the group or timer around it"
        context._host.warn_quirk(f"{text}, without its {', '.join(lost)}", origin)


def value_of_another_include(context: LaunchContext, name: str, origin: FileLine | None) -> None:
    """An argument gets a value that an unrelated, earlier include left behind."""
    setter = context.launch_configurations.origin_of(name)
    known = context._includers
    if setter is None or origin is None or setter.file not in known:
        return
    file: str | None = origin.file
    passed: set[str] = set()
    while file is not None and file not in passed:
        if file == setter.file:
            return
        passed.add(file)
        include = known.get(file)
        file = None if include is None else include.file
    value = context.launch_configurations.peek(name)
    text = f"argument '{name}' keeps the value '{value}' of {setter}: an include is not a scope"
    context._host.warn_quirk(text, origin)


def this_file_is_another(context: LaunchContext, what: str, origin: FileLine | None) -> None:
    """After an include, "this file" is the included one."""
    path = context.get_locals_as_dict().get("current_launch_file_path")
    if (
        origin is None
        or path is None
        or origin.file not in context._includers
        or origin.file == path
    ):
        return
    what = _written(what, origin)
    context._host.warn_quirk(f"{what} is that of {path}, which was included before", origin)


def setting_leaks(context: LaunchContext, what: str, origin: FileLine | None) -> None:
    """SetParameter and SetRemap leave a scoped group if there was one outside before."""
    what = _written(what, origin)
    text = f"{what} also applies after its group, because of an earlier one outside"
    context._host.warn_quirk(text, origin)


def text_is_no_text(context: LaunchContext, name: str, value: str, origin: FileLine | None) -> None:
    """SetParameter passes texts without quotes, and rcl reads a number or something else."""
    from launcher.base.model.parameter_text import rule

    if rule(name, value) != f"{name}:={value}":
        text = f"SetParameter passes '{value}' without quotes: nodes do not get it as a text"
        context._host.warn_quirk(text, origin)


def number_is_text(context: LaunchContext, name: str, value: str, origin: FileLine | None) -> None:
    """`1e-3` without a type is a text for YAML 1.1, and since Kilted for nodes, too."""
    from launcher.base.model.parameter_text import value_text

    number = value_text(float(value)).split()[0]
    text = (
        f"parameter '{name}' is the text '{value}', which is a number in Jazzy; "
        f"hint: write {number}, or give it a type"
    )
    context._host.warn_quirk(text, origin)


def parameter_file_is_missing(context: LaunchContext, path: str, origin: FileLine | None) -> None:
    """A node starts without a parameter file that does not exist."""
    text = f"Parameter file path is not a file: {path}; the node starts without it"
    folder, name = os.path.split(os.path.abspath(path))
    near = suggest(name, os.listdir(folder)) if os.path.isdir(folder) else None
    hint = f"; hint: did you mean '{near}'?" if near else ""
    context._host.warn_quirk(text + hint, origin)


def note_sim_time(context: LaunchContext, value: bool) -> None:
    """Remember whether timers of the launch file follow the clock of the simulation."""
    setattr(context, _SIM_TIME, value)


def sim_time_is_off(context: LaunchContext, origin: FileLine | None) -> None:
    """ROS 2 switches it off, takes the answer for a failure, and gives up."""
    text = f"{_written('SetUseSimTime', origin)} with false always ends the launch in ROS 2"
    context._host.warn_quirk(f"{text}, with exit code 1", origin)


def timer_is_on_wall_time(context: LaunchContext, origin: FileLine | None) -> None:
    """Nodes of this scope use simulated time, a RosTimer does not."""
    if not getattr(context, _SIM_TIME, False):
        ours = ("SetParameter('use_sim_time', True)", "SetUseSimTime(True)")
        if origin is not None and not origin.is_python:
            ours = ('<set_parameter name="use_sim_time">', '<set_use_sim_time value="true">')
        text = f"this timer follows wall time: {ours[0]} is for nodes, {ours[1]} for timers"
        context._host.warn_quirk(text, origin)
