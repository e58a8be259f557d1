"""Answers and stream items of the control socket as lines of text."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from launcher.base import strict_json
from launcher.base.model.event_entries import entry_of, line_of
from launcher.base.text import aligned, count, escape, shown_path

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_HEAD = ("NAME", "STATE", "PID", "RESTARTS", "UPTIME", "CPU", "USS", "")
_RIGHT = (2, 3, 4, 5, 6)  # columns that are aligned to the right
_RIGHT_WITH_HOSTS = (3, 4, 5, 6, 7)


LOCAL = "local"  # the host of processes of this machine
_COLOUR = re.compile(r"\x1b\[[0-9;:]*m")


def without_colour(text: str) -> str:
    return _COLOUR.sub("", text) if "\x1b" in text else text


def log_line(item: Mapping[str, Any]) -> str:
    """An item of `logs`, with the colours of the process."""
    if "dropped" in item:
        return f"({item['dropped']} lines were not read in time)"
    name = item["process"]
    return str(item["text"]) if name is None else f"[{name}] {item['text']}"


def event_line(item: Mapping[str, Any]) -> str:
    """An item of `events`, on one line; as JSON if it is no entry."""
    if "dropped" in item:
        return f"({item['dropped']} events were not read in time)"
    entry = entry_of(item)
    return strict_json.dumps(item) if entry is None else escape(line_of(entry), keep="")


def filters(row: Mapping[str, Any]) -> str:
    """`muted, 3 lines not shown`; empty if all output of the process is shown."""
    parts = []
    if row.get("muted"):
        is_outside = row.get("hidden_by") == "solo"
        parts += ["hidden by solo"] * is_outside
        parts += ["muted"] * (not is_outside or bool(row.get("muted_by_name")))
    if row.get("level"):
        parts.append(f"{row['level']} and above")
    if row.get("grep"):
        parts.append(f"lines with {row['grep']!r}")
    hidden = row.get("hidden_lines", 0)
    if parts and hidden:
        parts.append(f"{count(hidden, 'line')} not shown")
    return ", ".join(parts)


def table(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """`ps` in aligned columns; with the hosts if the run has some."""
    cells: list[tuple[str, ...]] = [_HEAD, *map(_cells, rows)]
    right: tuple[int, ...] = _RIGHT
    if any("host" in row for row in rows):
        hosts = ["HOST", *(row["host"] for row in rows)]
        cells = [(line[0], host, *line[1:]) for line, host in zip(cells, hosts, strict=True)]
        right = _RIGHT_WITH_HOSTS
    return aligned(cells, right)


def notes(result: Mapping[str, Any]) -> list[str]:
    """What `ps` shows below its table."""
    period_s, unanswered = result["sampled_every_s"], result.get("unanswered", ())
    found = []
    if period_s > 1:
        found.append(f"CPU and memory are sampled every {period_s:g} s: there are many processes")
    uptimes = {row["name"]: row["uptime_s"] for row in result["processes"]} if unanswered else {}
    for asked, reason in dict.fromkeys((one["asked"], one["reason"]) for one in unanswered):
        names = [one["name"] for one in unanswered if one["reason"] == reason]
        if asked:
            names = [f"{name}{_started(uptimes.get(name))}" for name in names]
            found.append(f"{reason}: {', '.join(names)}; it hangs or has no parameter services")
        else:
            found.append(f"not asked, {reason}: {', '.join(names)}")
    return found


def _started(uptime_s: float | None) -> str:
    return "" if uptime_s is None else f" (started {_duration(int(uptime_s))} ago)"


def unreachable(row: Mapping[str, Any]) -> str:
    """`unreachable 4 s`: what is known of the process is as old; empty if it is current."""
    silent_s = row.get("unreachable_s")
    if silent_s is None:
        return ""
    return f"unreachable {_duration(int(silent_s))}" if silent_s >= 1 else "unreachable"


def concern(row: Mapping[str, Any]) -> str:
    """What its state does not say: `unreachable 4 s`, `debugger at ...`, `injected: slow 4`."""
    address, silent_s = row.get("debugger"), row.get("not_responding_s")
    silent = f"not responding {_duration(int(silent_s))}" if silent_s else ""
    first = f"debugger at {address}" if address else unreachable(row) or silent
    injected = f"injected: {', '.join(row['injected'])}" if row.get("injected") else ""
    return ", ".join(filter(None, [first, injected]))


def _with_concern(state: str, row: Mapping[str, Any]) -> str:
    return ", ".join(filter(None, [state, concern(row)]))


def readiness(row: Mapping[str, Any]) -> str:
    """`waiting for dispatcher: no publisher on /fleet/tasks (4.2 s)`, `not ready: ...`, `ready`.

    Empty where nothing says when the process is ready.
    """
    if row.get("waiting_for"):
        return f"waiting for {row['waiting_for']}"
    if row.get("ready"):
        return f"ready after {row['ready_s']:.1f} s"
    return f"not ready: {row['lacks']}" if row.get("lacks") else ""


def _cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    remarks = [
        readiness(row),
        "warm" if row.get("start") == "warm" and row["pid"] is not None else "",
        filters(row),
    ]
    if row.get("faults"):
        remarks.append(f"faults: {first_of(row['faults'])}")
    if row["pid"] is None and row["last_exit"] is not None:
        remarks.append(row["last_exit"]["text"])
    return (
        row["name"],
        _with_concern("PAUSED" if row["paused"] else row["state"], row),
        _or_dash(row["pid"]),
        str(row["restarts"]),
        _duration(row["uptime_s"]),
        _percent(row["cpu_percent"]),
        _size(row["uss_bytes"]),
        ", ".join(filter(None, remarks)),
    )


def info_lines(row: Mapping[str, Any]) -> list[str]:
    """`info` of one process."""
    last = row["last_exit"]
    asked = " (requested)" if last is not None and last["asked"] else ""
    facts = {
        **({"host": row["host"]} if "host" in row else {}),
        **({"unit": row["unit"]} if row.get("unit") else {}),
        "state": _with_concern(f"{row['state']}{', paused' if row['paused'] else ''}", row),
        **({"faults": ", ".join(row["faults"])} if row.get("faults") else {}),
        **({"ready": readiness(row) or "-"} if "ready" in row else {}),
        "pid": _or_dash(row["pid"]),
        "started": _or_dash(row.get("start_text")),
        "uptime": _duration(row["uptime_s"]),
        "nodes": ", ".join(row["node_names"]) or "-",
        "command": " ".join(row["cmd"]),
        "folder": folder(row),
        "restarts": f"{row['restarts']}; policy: {row['restart_policy']}",
        "stop": row["stop_policy"],
        "last exit": "-" if last is None else f"{last['text']}{asked}",
        "CPU": _percent(row["cpu_percent"]),
        "memory": f"{_size(row['uss_bytes'])} USS, {_size(row['rss_bytes'])} RSS",
        "threads": _or_dash(row["threads"]),
        "open files": _or_dash(row["fds"]),
        "shown": filters(row) or "everything",
        **({"watched": count(row["watched_files"], "file")} if row.get("watched_files") else {}),
        "log": log_file(row),
    }
    lines = [row["name"], *(f"  {name:<11}{value}" for name, value in facts.items())]
    return [*lines, *(f"  env        {text}" for text in variables(row))]


def variables(row: Mapping[str, Any]) -> list[str]:
    """How the environment differs from that of the launcher."""
    if row["env"] is None:
        return ["not known: another launcher started it"]
    found = [f"{name}={value}" for name, value in row["env_set"].items()]
    return found + [f"{name} is not set" for name in row["env_unset"]]


def _is_elsewhere(row: Mapping[str, Any]) -> bool:
    return bool(row.get("host", LOCAL) != LOCAL)


def log_file(row: Mapping[str, Any]) -> str:
    """The log file of a process in `info`, which is here in any case."""
    text = _or_dash(row["log_file"])
    return f"{text} (on this machine)" if row["log_file"] and _is_elsewhere(row) else text


def folder(row: Mapping[str, Any]) -> str:
    """The working directory of a process in `info`."""
    if not row["cwd"]:
        return f"the home on {row['host']}" if _is_elsewhere(row) else "same as the launcher"
    return str(row["cwd"]) if _is_elsewhere(row) else shown_path(row["cwd"])


def first_of(names: Sequence[str] | None) -> str:
    """`robot_1 reports +2`; empty without names."""
    if not names:
        return ""
    return f"{names[0]} +{len(names) - 1}" if len(names) > 1 else names[0]


def _or_dash(value: object) -> str:
    return "-" if value is None else str(value)


def _duration(seconds: float | None) -> str:
    if seconds is None:
        return "-"
    if seconds < 60:
        return f"{seconds} s" if isinstance(seconds, int) else f"{seconds:.1f} s"
    minutes, rest = divmod(int(seconds), 60)
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f} %"


def _size(value: int | None) -> str:
    return "-" if value is None else f"{value / 1e6:.1f} MB"
