"""Facts: what a run tells about its processes, as plain data and as lines for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from launcher import proc
from launcher.control.lines import not_shown
from launcher.control.names import Named
from launcher.engine.output.filters import LEVELS
from launcher.engine.process import Process
from launcher.engine.run_control import RunControl
from launcher.model.spec import ProcessSpec, RestartMode, RestartPolicy


def row(desk: RunControl, process: Process) -> dict[str, Any]:
    """One process in `ps`."""
    spec, child, view = process.spec, process.child, process.view
    sample = desk.sample_of(process)
    named = Named.of(spec)
    uptime_s = None
    if child is not None:
        uptime_s = round(desk.reactor.now() - process.machine.running_since, 3)
    return {
        "name": spec.name,
        "label": spec.label,
        "state": process.machine.state.value,
        "pid": None if child is None else child.pid,
        "restarts": process.machine.restarts,
        "uptime_s": uptime_s,
        "cpu_percent": None if sample is None else sample.cpu_percent,
        "memory_bytes": None if sample is None else sample.uss_bytes,
        "rss_bytes": None if sample is None else sample.rss_bytes,
        "threads": None if sample is None else sample.threads,
        "fds": None if sample is None else sample.fds,
        "node_names": list(named.nodes),
        "namespace": named.namespace,
        "muted": view is not None and view.is_silent,
        "muted_lines": 0 if view is None else view.hidden_lines,
        "level": None if view is None or not view.level else LEVELS[view.level],
        "grep": _pattern(process),
        "paused": child is not None and proc.is_suspended(child.pid),
        "last_exit": _last_exit(process),
    }


def _pattern(process: Process) -> str | None:
    if process.view is None or process.view.pattern is None:
        return None
    return process.view.pattern.text


def _last_exit(process: Process) -> dict[str, Any] | None:
    end = process.last_end
    if end is None:
        return None
    return {
        "returncode": end.outcome.returncode,
        "text": str(end.outcome),
        "asked": end.asked,
        "at": process.ended_wall_s,
    }


def info(desk: RunControl, process: Process, base: Mapping[str, str]) -> dict[str, Any]:
    """All that is known of one process; its environment is compared with `base`."""
    spec = process.spec
    ros = spec.ros
    log = None if desk.log_path is None else str(desk.log_path / f"{spec.name}.log")
    return {
        **row(desk, process),
        "command": list(spec.argv),
        "cwd": spec.cwd,
        "shell": spec.shell,
        "package": None if ros is None else ros.package,
        "executable": None if ros is None else ros.executable,
        "environment": dict(spec.env),
        "environment_set": {k: v for k, v in spec.env.items() if base.get(k) != v},
        "environment_unset": sorted(base.keys() - spec.env.keys()),
        "restart_policy": policy_text(spec.restart),
        "stop_policy": stop_text(spec),
        "log_file": log,
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


# ---- for people


def table(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """`ps` as lines with aligned columns."""
    head = ("NAME", "STATE", "PID", "RESTARTS", "UPTIME", "CPU", "MEMORY", "")
    cells = [head, *(_cells(one) for one in rows)]
    widths = [max(len(line[i]) for line in cells) for i in range(len(head))]
    return [
        "  ".join(
            cell.ljust(width) if i in (0, 1, 7) else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in cells
    ]


def _cells(one: Mapping[str, Any]) -> tuple[str, ...]:
    return (
        one["name"],
        "PAUSED" if one["paused"] else one["state"],
        _or_dash(one["pid"]),
        str(one["restarts"]),
        duration(one["uptime_s"]),
        percent(one["cpu_percent"]),
        size(one["memory_bytes"]),
        remark(one),
    )


def _or_dash(value: object) -> str:
    return "-" if value is None else str(value)


def duration(seconds: float | None) -> str:
    """`4.2 s`, `3 min 20 s`, `2 h 5 min`."""
    if seconds is None:
        return "-"
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(int(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"


def percent(value: float | None) -> str:
    """`12.5 %`."""
    return "-" if value is None else f"{value:.1f} %"


def size(value: int | None) -> str:
    """`48.1 MB`."""
    return "-" if value is None else f"{value / 1e6:.1f} MB"


def remark(one: Mapping[str, Any]) -> str:
    """What is out of the ordinary: muted, filtered, how it ended."""
    parts = []
    if one["muted"]:
        parts.append("muted")
    if one["level"]:
        parts.append(f"{one['level']} and above")
    if one["grep"]:
        parts.append(f"lines with {one['grep']!r}")
    if parts:
        parts.append(not_shown(one["muted_lines"]))
    if one["pid"] is None and one["last_exit"] is not None:
        parts.append(one["last_exit"]["text"])
    return ", ".join(parts)


def info_lines(one: Mapping[str, Any]) -> list[str]:
    """`info` as lines."""
    last = one["last_exit"]
    asked = " (asked)" if last is not None and last["asked"] else ""
    facts = {
        "state": f"{one['state']}{', paused' if one['paused'] else ''}",
        "pid": _or_dash(one["pid"]),
        "uptime": duration(one["uptime_s"]),
        "nodes": ", ".join(one["node_names"]) or "-",
        "command": " ".join(one["command"]),
        "folder": one["cwd"] or "that of the launcher",
        "restarts": f"{one['restarts']}; policy: {one['restart_policy']}",
        "stop": one["stop_policy"],
        "last exit": "-" if last is None else f"{last['text']}{asked}",
        "CPU": percent(one["cpu_percent"]),
        "memory": f"{size(one['memory_bytes'])} (resident {size(one['rss_bytes'])})",
        "threads": _or_dash(one["threads"]),
        "open files": _or_dash(one["fds"]),
        "shown": remark({**one, "pid": 0}) or "everything",
        "log": _or_dash(one["log_file"]),
    }
    lines = [one["name"], *(f"  {name:<11}{value}" for name, value in facts.items())]
    lines += [f"  env        {name}={value}" for name, value in one["environment_set"].items()]
    return lines + [f"  env        {name} is not set" for name in one["environment_unset"]]
