"""Builds the ProcessSpec of a prepared action."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.base.model.record import replace
from launcher.base.model.spec import (
    ParameterSource,
    ProcessSpec,
    RestartMode,
    RestartPolicy,
    RosIdentity,
    StopPolicy,
)
from launcher.language.substitution import perform_substitutions
from launcher.language.substitutions.configuration import LaunchConfiguration

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.actions.process import ExecuteLocal
    from launcher.language.context import LaunchContext


def make_spec(
    action: ExecuteLocal, context: LaunchContext, generated: Mapping[str, Any]
) -> ProcessSpec:
    """The final spec; `generated` maps parameter files written so far to their content."""
    description = action.process_description
    if description.final_cmd is None or description.final_env is None:
        name = type(description).__name__
        raise RuntimeError(f"{name}.prepare() prepares no command: call super().prepare() in it")
    if not description.final_cmd:
        # Imported only for an error.
        from launcher.language.diagnostics.bad_entries import NoCommandError

        raise NoCommandError
    if " " in description.final_cmd[0] and not action.shell:
        # Imported only for a probable mistake.
        from launcher.language.diagnostics.text_uses import warn_of_one_word

        warn_of_one_word(description.final_cmd, context, action)
    sigterm, sigkill = (
        perform_substitutions(context, subs)
        for subs in (action.sigterm_timeout, action.sigkill_timeout)
    )
    return ProcessSpec(
        name=str(description.final_name),
        label=str(description._label),
        argv=tuple(description.final_cmd),
        env=description.final_env,
        cwd=description.final_cwd,
        shell=bool(action.shell),
        emulate_tty=action._spawn_emulates_tty(context),
        output=action._output_policy,
        output_given=action._output_given,
        chooses_output=action._chooses_output,
        restart=_restart_policy(action, context),
        stop=_stop_policy(action, context, sigterm, sigkill),
        ros=_with_contents(action._ros_identity(), generated),
        sigterm_timeout_given=sigterm,
        sigkill_timeout_given=sigkill,
        place="the launch file" if action._origin is None else str(action._origin),
    )


def _restart_policy(action: ExecuteLocal, context: LaunchContext) -> RestartPolicy:
    respawn, delay_s, retries = action._respawn_settings()
    if not respawn:
        return RestartPolicy()
    given = action._respawn_delay_given
    if delay_s is None and given is not None:
        # ROS 2 fails when it is about to start the process again, so it must start here as well.
        text = f"respawn_delay {given!r} is not a number of seconds; using 0"
        context._host.warn_quirk(text, action._origin)
    limit = retries if isinstance(retries, int) and retries >= 0 else None
    return RestartPolicy(mode=RestartMode.ALWAYS, delay_s=delay_s or 0.0, max_restarts=limit)


def _stop_policy(
    action: ExecuteLocal, context: LaunchContext, sigterm: str, sigkill: str
) -> StopPolicy:
    default = StopPolicy()
    seconds = []
    for name, text, subs, default_s in (
        ("sigterm_timeout", sigterm, action.sigterm_timeout, default.sigterm_timeout_s),
        ("sigkill_timeout", sigkill, action.sigkill_timeout, default.sigkill_timeout_s),
    ):
        value_s, problem = _seconds(text, default_s)
        if problem is not None:
            is_for_all = any(isinstance(sub, LaunchConfiguration) for sub in subs)
            origin = None if is_for_all else action._origin
            context._host.warn_quirk(f"{name} '{text}' {problem}", origin)
        seconds.append(value_s)
    return StopPolicy(sigterm_timeout_s=seconds[0], sigkill_timeout_s=seconds[1])


def _seconds(text: str, default_s: float) -> tuple[float, str | None]:
    """(seconds to wait, what is wrong with the text).

    ROS 2 parses these texts only when it stops the process, so a bad one must not prevent the
    start. In ROS 2 a bad text ends the escalation or waits forever; here the stop always ends.
    """
    try:
        value_s = float(text)
    except ValueError:
        value_s = float("nan")
    if not abs(value_s) < float("inf"):  # also for nan; avoids importing math
        return default_s, f"is not a number of seconds; using {default_s:g}"
    if value_s < 0:
        return 0.0, "is negative; using 0"
    return value_s, None


def _with_contents(
    identity: RosIdentity | None, generated: Mapping[str, Any]
) -> RosIdentity | None:
    if identity is None:
        return None
    parameters = tuple(
        ParameterSource(file=source.file, generated=generated[source.file])
        if source.file is not None and source.file in generated
        else source
        for source in identity.parameters
    )
    return replace(identity, parameters=parameters)
