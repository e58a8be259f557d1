"""The document of `plan --json`."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.language.substitution import plain_text

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any

    from launcher.base.model.events import LoadRequest
    from launcher.base.model.spec import ParameterSource
    from launcher.language.actions.arguments import DeclareLaunchArgument
    from launcher.launch.plan.plan import Plan, PlanError, PlannedProcess, Stamp
    from launcher.launch.plan.plan_places import Placed

GENERATED = "<generated>"
VERSION = 1  # see docs/plan-json.md


def document(plan: Plan, placed: Sequence[Placed] = ()) -> dict[str, Any]:
    """The document; `placed` are the processes on their hosts, if there is a hosts file."""
    result: dict[str, Any] = {
        "version": VERSION,
        "arguments": None
        if plan.arguments is None
        else [_argument(argument) for argument in plan.arguments],
        "declared": dict(plan.declared),
        "processes": [_process(process, plan.environment) for process in plan.processes],
        "loads": [{**_load(load), **_stamp(stamp)} for load, stamp in plan.loads],
        "lifecycle": [
            {"node": change.node, "transition": change.transition, **_stamp(stamp)}
            for change, stamp in plan.lifecycle
        ],
        "logs": [{"message": text, **_stamp(stamp)} for text, stamp in plan.logs],
        "shutdowns": [{"reason": reason, **_stamp(stamp)} for reason, stamp in plan.shutdowns],
        "error": None if plan.error is None else _error(plan.error),
    }
    if placed:
        for entry, process, one in zip(result["processes"], plan.processes, placed, strict=True):
            entry.update(one.document(plan.environment, process.spec.env))
    if plan.start_rules:
        from launcher.launch.plan.start_rules import start_document

        for entry, process in zip(result["processes"], plan.processes, strict=True):
            entry.update(start_document(plan, process))
    if plan.arguments is None:
        result["arguments_error"] = plan.arguments_error
    return result


def _argument(argument: DeclareLaunchArgument) -> dict[str, Any]:
    default = argument.default_value
    return {
        "name": argument.name,
        "description": argument.description,
        "has_default": default is not None,
        "default": None if default is None else plain_text(default),
        "choices": None if argument.choices is None else list(argument.choices),
    }


def _process(process: PlannedProcess, environment: Mapping[str, str]) -> dict[str, Any]:
    spec = process.spec
    ros = spec.ros
    sources = ros.parameters if ros else ()
    generated = {source.file for source in sources if source.generated is not None}
    return {
        "package": ros and ros.package,
        "executable": ros and ros.executable,
        "node_name": ros and ros.node_name,
        "namespace": ros and ros.namespace,
        "remappings": [list(rule) for rule in ros.remappings] if ros else [],
        "cmd": [GENERATED if word in generated else word for word in spec.argv],
        "parameters": [_parameter(source) for source in sources],
        "env_set": changed_variables(spec.env, environment),
        "env_unset": sorted(name for name in environment if name not in spec.env),
        "cwd": spec.cwd,
        "shell": spec.shell,
        "output": _output(spec.output_given),
        "emulate_tty": spec.emulate_tty,
        "respawn": process.respawn,
        "respawn_delay": process.respawn_delay,
        "respawn_max_retries": process.respawn_max_retries,
        "sigterm_timeout": spec.sigterm_timeout_given,
        "sigkill_timeout": spec.sigkill_timeout_given,
        "label": spec.label,
        **_stamp(process.stamp),
    }


def _parameter(source: ParameterSource) -> dict[str, Any]:
    if source.rule is not None:
        return {"rule": source.rule}
    if source.generated is not None:
        return {"generated": _plain(source.generated)}
    return {"file": source.file}


def _output(output: object) -> Any:
    if not isinstance(output, Mapping):
        return output
    return {
        key: sorted(value) if isinstance(value, (set, frozenset, list, tuple)) else value
        for key, value in output.items()
    }


def _load(load: LoadRequest) -> dict[str, Any]:
    return {
        "container": load.container,
        "package": load.package,
        "plugin": load.plugin,
        "name": load.name or "",
        "namespace": load.namespace or "",
        "remappings": [list(rule) for rule in load.remappings],
        "parameters": [[name, _plain(value)] for name, value in load.parameters],
        "extra_arguments": [[name, _plain(value)] for name, value in load.extra_arguments],
    }


def _plain(value: object) -> object:
    if isinstance(value, bytes):
        return f"<bytes {value.hex()}>"
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (str, int, float, bool, type(None))):
        return value
    return str(value)


def _stamp(stamp: Stamp) -> dict[str, Any]:
    return {
        "time": stamp.time_s,
        "phase": stamp.phase,
        "cause": stamp.cause,
        "since_cause": stamp.since_cause_s,
    }


def _error(error: PlanError) -> dict[str, Any]:
    return {
        "type": error.kind,
        "message": error.message,
        "stage": error.stage,
        "phase": error.phase,
    }


def changed_variables(env: Mapping[str, str], before: Mapping[str, str]) -> dict[str, str]:
    """The variables that are new or different, apart from what the launcher itself has added."""
    changed = {name: value for name, value in env.items() if before.get(name) != value}
    path = changed.get("AMENT_PREFIX_PATH")
    if path is not None:
        from launcher.packages.overlay import without_overlays  # few launch files change it

        if without_overlays(path) == before.get("AMENT_PREFIX_PATH", ""):
            del changed["AMENT_PREFIX_PATH"]
    return changed
