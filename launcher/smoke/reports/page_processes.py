"""The processes of a run for its page: their state before the stop, and their history."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from launcher.base.model.run_event import exit_text
from launcher.base.model.run_events import Ended, Resources, Started
from launcher.smoke.observe.facts import Facts, label_of
from launcher.smoke.reports.result import SmokeResult

MAX_SAMPLES = 600  # as a page keeps of a run that it follows
_GONE = ("pid", "uptime_s", "cpu_percent", "uss_bytes", "rss_bytes", "threads", "fds")
_FINAL = ("FATAL", "BACKOFF")

Row = dict[str, Any]


def rows_of(
    result: SmokeResult, errors: Mapping[str | None, Row], history: Mapping[str, Row]
) -> list[Row]:
    """The rows of `ps` as they were when the system was stopped."""
    facts, last = result.facts, result.last_state
    known = {row["name"]: dict(row) for row in (last.rows if last else ())}
    names = [*known, *(name for name in facts.processes() if name not in known)]
    rows = [known.get(name) or _unknown(name, facts) for name in names]
    for row in rows:
        _bring_up_to_date(row, result)
        row["lines_per_s"] = (history.get(row["name"], {}).get("lines") or [0.0])[-1]
        row["last_error"] = errors.get(row["name"])
    return rows


def _unknown(name: str, facts: Facts) -> Row:
    """A process that was over before anybody could ask."""
    row = dict.fromkeys((*_GONE, "level", "grep", "hidden_by", "debugger", "start"))
    started = next(facts.of(Started, name), None)
    return {
        **row,
        "name": name,
        "label": label_of(name),
        "state": "RUNNING" if started else "FATAL",
        "pid": started and started.event.pid,
        "restarts": 0,
        "node_names": list(facts.node_names.get(name, ())),
        "namespace": "/",
        "muted": False,
        "muted_by_name": False,
        "hidden_lines": 0,
        "paused": False,
        "not_responding_s": None,
        "last_exit": None,
    }


def _bring_up_to_date(row: Row, result: SmokeResult) -> None:
    """The rows are up to a second old; an exit since then is what a reader looks for."""
    facts = result.facts
    events = [
        event
        for event in facts.events
        if event.process == row["name"]
        and isinstance(event.event, (Started, Ended))
        and event.at_s <= facts.stop_s
    ]
    end = events[-1].event if events else None
    if not isinstance(end, Ended):
        return
    row.update(dict.fromkeys(_GONE))
    if row["state"] not in _FINAL:
        row["state"] = "EXITED"
    row["last_exit"] = row.get("last_exit") or _exit(end, result.started_s + events[-1].at_s)


def _exit(end: Ended, wall_s: float) -> Row:
    return {
        "returncode": end.returncode,
        "text": exit_text(end.returncode),
        "asked": end.asked,
        "wall_s": wall_s,
    }


def history_of(facts: Facts, started_s: float) -> dict[str, Any]:
    """The message `history`: what the samples of the run say, at most `MAX_SAMPLES`."""
    samples = [*facts.of(Resources)]
    times = [sample.at_s for sample in samples]
    rates = _rates(facts, times)
    found: dict[str, dict[str, list[Any]]] = {}
    for name in facts.processes():
        used = [sample.event.processes.get(name) for sample in samples]
        cpu = [one and one.cpu_percent for one in used]
        memory = [one and one.uss_bytes for one in used]
        found[name] = {"cpu": cpu, "memory": memory, "lines": rates[name]}
    step = max(1, -(-len(samples) // MAX_SAMPLES))
    thinned = {
        name: {key: _highest(values, step) for key, values in lines.items()}
        for name, lines in found.items()
    }
    wall = [started_s + time_s for time_s in times[step - 1 :: step] or times[-1:]]
    if step > 1 and len(times) % step:
        wall.append(started_s + times[-1])
    return {"event": "history", "wall": wall, "processes": thinned}


def _rates(facts: Facts, times: Sequence[float]) -> dict[str, list[float]]:
    """Lines a second of each process, between the samples."""
    lines = {name: [0.0] * len(times) for name in facts.processes()}
    counts: Counter[str | None] = Counter()
    before_s, number = 0.0, 0
    for index, time_s in enumerate(times):
        counts.clear()
        while number < len(facts.lines) and facts.lines[number].at_s <= time_s:
            counts[facts.lines[number].process] += 1
            number += 1
        for name, count in counts.items():
            if name in lines:
                lines[name][index] = round(count / max(time_s - before_s, 0.1), 2)
        before_s = time_s
    return lines


def _highest(values: Sequence[Any], step: int) -> list[Any]:
    """The highest of each `step` values: a peak must not get lost."""
    if step == 1:
        return list(values)
    groups = (values[begin : begin + step] for begin in range(0, len(values), step))
    return [max((one for one in group if one is not None), default=None) for group in groups]
