"""Checks between the evaluation of a launch file and its first process; UsageError.

Imported only when a command line or an environment needs one of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from launcher.base.errors import LauncherError, UsageError
from launcher.base.model.events import Effect, LogMessage, StartProcess
from launcher.base.model.run_options import RunOptions, matches
from launcher.base.model.supervision import StartRule
from launcher.base.text import several
from launcher.language import launch_session
from launcher.language.configurations import ROS_NAMES
from launcher.launch import mistakes
from launcher.launch.known_names import KnownNames
from launcher.posix.domains import is_domain
from launcher.posix.ports import MAX_DOMAIN
from launcher.posix.stdio import silence
from launcher.run.option_warnings import nearest

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.description import LaunchDescription
    from launcher.language.interpreter import Interpreter

_MAX_NAMES = 3


def unknown_arguments(
    interpreter: Interpreter, description: LaunchDescription
) -> tuple[list[LauncherError], list[str]]:
    """As `mistakes.unknown_names`, after the evaluation of the static part."""
    host = interpreter.host
    unused = [(name, interpreter.arguments[name]) for name in interpreter.unused_arguments]
    if not unused:
        return [], []
    with silence():
        known = KnownNames(
            {*host.declared_values, *host.names_read, *ROS_NAMES},
            description,
            interpreter.context,
            reads_arguments=launch_session.current().reads_arguments,
        )
    return mistakes.unknown_names(unused, known, host.declared_values)


def refuse_domain(word: str, effects: Iterable[Effect]) -> None:
    """Refuse a ROS_DOMAIN_ID that a node would get and with which it could not start."""
    if is_domain(word):
        return
    specs = [effect.spec for effect in effects if isinstance(effect, StartProcess)]
    nodes = [spec.name for spec in specs if spec.ros and spec.env.get("ROS_DOMAIN_ID") == word]
    if not nodes:
        return
    names = several(nodes, _MAX_NAMES)
    raise UsageError(
        f"ROS_DOMAIN_ID is '{word}', which is not a valid domain id: no node can start ({names})",
        hint=f"a domain is a number from 0 to {MAX_DOMAIN}: export ROS_DOMAIN_ID=0, or unset it",
    )


def refuse_other_domains(options: RunOptions, effects: Iterable[Effect]) -> None:
    """Refuse processes that the launch file puts into another domain than that of `--private`."""
    for spec in (effect.spec for effect in effects if isinstance(effect, StartProcess)):
        domain = spec.env.get("ROS_DOMAIN_ID")
        if domain != str(options.domain_id):
            what = "no ROS_DOMAIN_ID" if domain is None else f"ROS_DOMAIN_ID={domain}"
            raise UsageError(
                f"--private does not apply: {spec.name} ({spec.place}) has {what}",
                hint="leave out --private, or what sets the domain in the launch file",
            )


def refuse_circles(rules: Sequence[StartRule], effects: Iterable[Effect]) -> None:
    """Refuse processes that wait for each other."""
    from launcher.launch.supervise.circles import circle_among

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
