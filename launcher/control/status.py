"""Processes as rows of JSON, for `ps`, `top` and `info`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from launcher.base.model.spec import ProcessSpec, RestartMode, RestartPolicy
from launcher.output.filters import LEVELS, LineFilter
from launcher.run.part import Part
from launcher.run.processes.process import Process
from launcher.run.requests.process_selection import nodes_of
from launcher.run.run import Run

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.base.model.run_events import Sample


def rows(run: Run, processes: Iterable[Process], *, looks: bool = True) -> list[dict[str, Any]]:
    """Processes in `ps`.

    `looks`: whether each of them is suspended is read from /proc now, which takes two thirds of the
    time of a row; else that is as old as its CPU and memory, or as the last request about it.
    """
    keeper, now = run.housekeeper, run.reactor.now()
    parts = [part for part in run.parts if type(part).row is not Part.row]
    return [
        {
            **_row(process, keeper.sample_of(process), now),
            "paused": process.is_halted if looks else process.was_halted,
            **{name: value for part in parts for name, value in part.row(process).items()},
        }
        for process in processes
    ]


def _row(process: Process, sample: Sample | None, now: float) -> dict[str, Any]:
    spec, child, shown = process.spec, process.child, process.filter
    nodes, namespace = nodes_of(spec)
    uptime_s, since_s = None, process.machine.running_since
    if child is not None and since_s is not None:
        uptime_s = round(now - since_s, 3)
    return {
        "name": spec.name,
        "label": spec.label,
        "state": process.machine.state.value,
        "pid": None if child is None else child.pid,
        "restarts": process.machine.restarts,
        "uptime_s": uptime_s,
        "cpu_percent": sample and sample.cpu_percent,
        "uss_bytes": sample and sample.uss_bytes,
        "rss_bytes": sample and sample.rss_bytes,
        "threads": sample and sample.threads,
        "fds": sample and sample.fds,
        "node_names": list(nodes),
        "namespace": namespace,
        "muted": shown is not None and shown.is_silent,
        "hidden_by": _hidden_by(shown),
        "muted_by_name": shown is not None and shown.muted,
        "hidden_lines": 0 if shown is None else shown.hidden_lines,
        "level": None if shown is None or not shown.level else LEVELS[shown.level],
        "grep": None if shown is None or shown.pattern is None else shown.pattern.text,
        "debugger": process.debugger and process.debugger.address,
        "start": _start(process),
        "not_responding_s": _silent_s(process, now),
        "last_exit": _last_exit(process),
    }


def _silent_s(process: Process, now: float) -> float | None:
    """0 while its node answers, None while that is not known."""
    if process.silence is None:
        return 0.0 if process.answers else None
    return round(process.silence.elapsed_s(now), 1)


def _start(process: Process) -> str | None:
    """`warm` or `cold`; None before the first start."""
    return process.start_kind.partition(",")[0] or ("cold" if process.history.starts else None)


def _hidden_by(shown: LineFilter | None) -> str | None:
    """The verb that hides all lines of a process."""
    if shown is None or not shown.is_silent:
        return None
    return "solo" if shown.outside else "mute"


def _last_exit(process: Process) -> dict[str, Any] | None:
    end = process.last_end
    if end is None:
        return None
    return {
        "returncode": end.outcome.returncode,
        "text": str(end.outcome),
        "asked": end.asked,
        "wall_s": process.ended_wall_s,
    }


def info(run: Run, process: Process, base: Mapping[str, str]) -> dict[str, Any]:
    """A process in `info`; `base` is the environment that its own is compared with.

    That is known only on the host if the run was attached to.
    """
    spec, ros, logs = process.spec, process.spec.ros, run.log_dir
    is_known = process.host is None or bool(spec.env)
    started = spec if process.debugger is None else process.debugger.spec
    return {
        **rows(run, (process,))[0],
        "cmd": list(process.words_there or started.argv),
        "cwd": spec.cwd if process.host is None else process.folder_there,
        "shell": spec.shell,
        "start_text": process.start_kind or _start(process),
        "package": ros and ros.package,
        "executable": ros and ros.executable,
        "env": dict(spec.env) if is_known else None,
        "env_set": {k: v for k, v in spec.env.items() if base.get(k) != v},
        "env_unset": sorted(base.keys() - spec.env.keys()) if is_known else [],
        "restart_policy": policy_text(spec.restart),
        "stop_policy": stop_text(spec),
        "watched_files": None,
        "log_file": None if logs is None else f"{logs}/{spec.name}.log",
        **{name: value for part in run.parts for name, value in part.info(process).items()},
    }


def policy_text(policy: RestartPolicy) -> str:
    """`on-failure, at most 5 within 60 s, after 0.5 s to 30 s`."""
    if policy.mode is RestartMode.NEVER:
        return "never"
    parts = [policy.mode.value]
    if policy.max_restarts is not None:
        within = "" if policy.window_s is None else f" within {policy.window_s:g} s"
        parts.append(f"at most {policy.max_restarts}{within}")
    if policy.backoff_max_s is not None:
        parts.append(f"after {policy.delay_s:g} s to {policy.backoff_max_s:g} s")
    elif policy.delay_s:
        parts.append(f"after {policy.delay_s:g} s")
    return ", ".join(parts)


def stop_text(spec: ProcessSpec) -> str:
    """`SIGINT, after 5 s SIGTERM, after 5 s SIGKILL`."""
    text, wait_s = "", 0.0
    for signum, next_s in spec.stop.steps:
        text += f", after {wait_s:g} s {signum.name}" if text else signum.name
        wait_s = next_s
    return text
