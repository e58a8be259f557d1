"""Prints what is planned of a launch file, for processes that ask for it by `python -m`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from launcher.base import strict_json
from launcher.base.errors import ExitCode, LauncherError
from launcher.launch.plan.planner import Plan
from launcher.launch.target import LaunchRequest
from launcher.launch.verbs import launch
from launcher.launch.verbs import plan as planning

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def print_planned(words: Sequence[str], document: Callable[[Plan], Any]) -> int:
    """Print `document` of the plan as JSON; nothing if the launch file cannot be planned.

    `words` are those of a launch. Returns the exit code.
    """
    try:
        plan = planning.evaluate(LaunchRequest.of(launch.COMMAND.parse(words)))
    except LauncherError as error:
        return error.exit_code
    if plan.error is not None:
        return ExitCode.USAGE
    print(strict_json.packed(document(plan)))
    return ExitCode.OK
