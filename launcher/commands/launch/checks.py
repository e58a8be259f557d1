"""Checks between the evaluation of a launch file and its first process; UsageError.

Imported only when a command line or an environment needs one of them.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence

from launcher.commands.launch import mistakes
from launcher.commands.launch.known_names import known_names
from launcher.commands.launch.target import LaunchRequest
from launcher.engine.option_warnings import nearest
from launcher.errors import UsageError
from launcher.model.events import Effect, LogMessage, StartProcess
from launcher.model.options import matches
from launcher.model.supervision import StartRule
from launcher.planner import make_plan
from launcher.ros.discovery.domains import is_domain
from launcher.ros.discovery.ports import MAX_DOMAIN
from launcher.stdio import silence

_MAX_NAMES = 3


def refuse_unknown_arguments(request: LaunchRequest) -> None:
    """LauncherError if a dry run shows that nothing declares or reads one of the arguments."""
    with silence():
        plan = make_plan(request.path, request.arguments)
        known = known_names(plan)
    errors = mistakes.unknown_names(request.arguments, known, plan.declared)
    if not errors:
        return
    if plan.error is not None:
        errors += mistakes.of_launch_file(
            plan.error.fault, plan.description, plan.context, request.arguments, os.environ
        )
    raise mistakes.together(errors)


def refuse_domain(word: str, effects: Iterable[Effect]) -> None:
    """Refuse a ROS_DOMAIN_ID that a node would get and with which it could not start."""
    if is_domain(word):
        return
    specs = [effect.spec for effect in effects if isinstance(effect, StartProcess)]
    nodes = [spec.name for spec in specs if spec.ros and spec.env.get("ROS_DOMAIN_ID") == word]
    if not nodes:
        return
    names = ", ".join(nodes[:_MAX_NAMES])
    more = f" and {len(nodes) - _MAX_NAMES} more" if len(nodes) > _MAX_NAMES else ""
    raise UsageError(
        f"ROS_DOMAIN_ID is '{word}', which is not a valid domain id: "
        f"no node can start ({names}{more})",
        hint=f"a domain is a number from 0 to {MAX_DOMAIN}: export ROS_DOMAIN_ID=0, or unset it",
    )


def refuse_circles(rules: Sequence[StartRule], effects: Iterable[Effect]) -> None:
    """Refuse processes that wait for each other."""
    from launcher.commands.launch.supervise.circles import circle_among

    specs = [effect.spec for effect in effects if isinstance(effect, StartProcess)]
    error = circle_among(rules, specs)
    if error is not None:
        raise error


def refuse_missing(required: Sequence[str], effects: Sequence[Effect]) -> None:
    """Refuse a required process that these effects neither start nor could start later."""
    if not all(isinstance(effect, (StartProcess, LogMessage)) for effect in effects):
        return  # a timer, a component
    specs = [one.spec for one in effects if isinstance(one, StartProcess)]
    for pattern in required:
        if not any(matches(pattern, spec) for spec in specs):
            names = ", ".join(spec.name for spec in specs) or "none"
            raise UsageError(
                f"--required '{pattern}' matches no process{nearest(pattern, specs)}",
                hint=f"processes: {names}",
            )
