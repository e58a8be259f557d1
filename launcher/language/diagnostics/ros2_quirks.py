"""Warnings about surprising behaviour of ROS 2 that this launcher reproduces."""

from __future__ import annotations

import os

from launcher.base.text import suggest

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.context import LaunchContext
    from launcher.language.diagnostics.origin import FileLine

_SIM_TIME = "_is_on_sim_time"  # attribute of the context


def scope_is_lost(context: LaunchContext, origin: FileLine | None) -> None:
    """An event handler in a scoped group, or in a timer, runs its actions outside of that scope."""
    lost = context._lost_later()
    if lost:
        text = "the actions of this event handler run outside of the group or timer around it"
        context._host.warn_quirk(f"{text}, without its {', '.join(lost)}", origin)


def value_of_another_include(context: LaunchContext, name: str, origin: FileLine | None) -> None:
    """An argument gets a value that an unrelated, earlier include left behind."""
    setter = context.launch_configurations.origin_of(name)
    known = context._includers
    if setter is None or origin is None or setter.path not in known:
        return
    file: str | None = origin.path
    passed: set[str] = set()
    while file is not None and file not in passed:
        if file == setter.path:
            return
        passed.add(file)
        include = known.get(file)
        file = None if include is None else include.path
    value = context.launch_configurations.peek(name)
    text = f"argument '{name}' keeps the value '{value}' of {setter}: an include is not a scope"
    context._host.warn_quirk(text, origin)


def this_file_is_another(context: LaunchContext, what: str, origin: FileLine | None) -> None:
    """After an include, "this file" is the included one."""
    path = context.get_locals_as_dict().get("current_launch_file_path")
    if (
        origin is None
        or path is None
        or origin.path not in context._includers
        or origin.path == path
    ):
        return
    context._host.warn_quirk(f"{what} is that of {path}, which was included before", origin)


def setting_leaks(context: LaunchContext, what: str, origin: FileLine | None) -> None:
    """SetParameter and SetRemap leave a scoped group if there was one outside before."""
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


def timer_is_on_wall_time(context: LaunchContext, origin: FileLine | None) -> None:
    """Nodes of this scope use simulated time, a RosTimer does not."""
    if not getattr(context, _SIM_TIME, False):
        text = (
            "this timer follows wall time: SetParameter('use_sim_time', True) is for nodes, "
            "SetUseSimTime(True) for timers"
        )
        context._host.warn_quirk(text, origin)
