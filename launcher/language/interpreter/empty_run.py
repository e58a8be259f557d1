"""The message about a launch file that starts nothing, with the conditions that were false."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

from launcher.language.actions.process import OnProcessExit
from launcher.language.diagnostics.truth_values import configurations_in
from launcher.language.substitution import description_of

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

_MAX_LISTED = 5  # conditions


# Actions that start nothing, whether their condition is true or not, by the names of ROS 2.
_HARMLESS = (
    "Append",
    "Declare",
    "EmitEvent",
    "Log",
    "Pop",
    "Push",
    "Replace",
    "Reset",
    "Set",
    "Shutdown",
    "Unregister",
    "Unset",
)


def may_start(action: Any) -> bool:
    """Whether an action might have started something, itself or by what it yields."""
    of_launch = (cls for cls in type(action).__mro__ if cls.__module__.startswith("launch"))
    return not next(of_launch).__name__.startswith(_HARMLESS)


def handler_may_start(handler: Any) -> bool:
    """Whether an event handler of the launch file may start something."""
    is_of_user = type(handler) is OnProcessExit or handler._origin is not None
    _, entities = handler.describe() if is_of_user else ("", [None])
    return not entities or any(map(may_start, filter(None, entities)))


def values_of(condition: object, context: LaunchContext) -> dict[str, Any]:
    """The launch configurations that a condition reads, with their values now."""
    names = dict.fromkeys(configurations_in(condition))
    return {name: context.launch_configurations.peek(name) for name in names}


def message(
    skipped: Sequence[tuple[Any, Mapping[str, Any]]], auxiliary: str, shutdown: str | None
) -> str:
    """`no process was started: ...`; `auxiliary` is `was` or `would be`.

    `shutdown` is the reason of a shutdown that the launch file has requested.
    """
    if shutdown is not None and not skipped:
        what = f"no process {auxiliary} started, since the launch file requests a shutdown"
        return f"{what}: {shutdown}"
    if not skipped:
        return f"no process {auxiliary} started"
    texts = list(dict.fromkeys(_false(action, values) for action, values in skipped))
    more = f"; and {len(texts) - _MAX_LISTED} more" if len(texts) > _MAX_LISTED else ""
    number = "this condition is" if len(texts) == 1 else "these conditions are"
    return f"no process {auxiliary} started, since {number} false: " + (
        "; ".join(texts[:_MAX_LISTED]) + more
    )


def _false(action: Any, values: Mapping[str, Any]) -> str:
    """`IfCondition(LaunchConfig('x')) of Node at demo.launch.py:8 (x is 'false')`."""
    origin = action._origin
    place = "" if origin is None else f" at {os.path.basename(origin.path)}:{origin.line}"
    known = [
        f"{name} is not set" if value is None else f"{name} is '{value}'"
        for name, value in values.items()
    ]
    given = f" ({', '.join(known)})" if known else ""
    return f"{description_of(action.condition)} of {type(action).__name__}{place}{given}"
