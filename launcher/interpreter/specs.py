"""Process specs: an action that was prepared, as the plain data that drivers work with."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.language.utilities import perform_substitutions
from launcher.model.record import replace
from launcher.model.spec import (
    ParameterSource,
    ProcessSpec,
    RestartMode,
    RestartPolicy,
    RosIdentity,
    StopPolicy,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.actions.process import ExecuteLocal
    from launcher.language.context import LaunchContext


def make_spec(
    action: ExecuteLocal, context: LaunchContext, generated: Mapping[str, Any]
) -> ProcessSpec:
    """The final spec; `generated` holds the content of the parameter files written so far."""
    description = action.process_description
    assert description.final_cmd is not None and description.final_env is not None
    if not description.final_cmd:
        from launcher.language.entries import NoCommandError  # most launch files have none

        raise NoCommandError
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
        restart=_restart_policy(action),
        stop=_stop_policy(sigterm, sigkill),
        ros=_with_contents(action._ros_identity(), generated),
        sigterm_timeout_given=sigterm,
        sigkill_timeout_given=sigkill,
    )


def _restart_policy(action: ExecuteLocal) -> RestartPolicy:
    respawn, delay_s, retries = action._respawn_settings()
    if not respawn:
        return RestartPolicy()
    limit = retries if isinstance(retries, int) and retries >= 0 else None
    return RestartPolicy(mode=RestartMode.ALWAYS, delay_s=delay_s or 0.0, max_restarts=limit)


def _stop_policy(sigterm: str, sigkill: str) -> StopPolicy:
    default = StopPolicy()
    return StopPolicy(
        sigterm_timeout_s=_seconds(sigterm, default.sigterm_timeout_s),
        sigkill_timeout_s=_seconds(sigkill, default.sigkill_timeout_s),
    )


def _seconds(text: str, default_s: float) -> float:
    # ROS 2 looks at these texts only when it stops the process, so a bad one is no start error.
    try:
        return float(text)
    except ValueError:
        return default_s


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
