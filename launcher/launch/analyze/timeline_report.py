"""A timeline as text and as JSON."""

from __future__ import annotations

from typing import Any

from launcher.base.text import count, escape, shown_path
from launcher.launch.analyze.timeline import FirstStart, Timeline, critical_chain

_MIN_BAR = 20  # columns
_BAR_SHARE = 0.1  # of what follows the start-up that is shown as well
_MAX_NAME = 30
_NO_FACTS = (
    "nothing says when these processes are ready: the times end when they run; "
    "ready_when in NAME.supervise.yaml says more (docs/reference/supervision.md)"
)


def lines(found: Timeline, columns: int) -> list[str]:
    """The summary, the timeline, the slowest processes and the critical chain."""
    parts = [_summary(found), _plot(found, columns), _slowest(found), _chain(found)]
    if not any(one.has_facts for one in found.processes.values()):
        parts.append([_NO_FACTS])
    return [line for part in parts if part for line in (*part, "")][:-1]


def _summary(found: Timeline) -> list[str]:
    processes = list(found.processes.values())
    first_s = min((one.queued_s for one in processes), default=0.0)
    done = len(processes) - len(found.unready)
    words = f"{done} of {count(len(processes), 'process')} ready"
    texts = [
        f"{words} after {found.done_s:.2f} s, the first was asked for after {first_s:.2f} s",
        f"log files: {escape(shown_path(found.folder))}",
    ]
    for one in found.unready:
        texts.append(f"not ready: {_name(one)} ({_state(one)})")
    return texts


def _state(start: FirstStart) -> str:
    if start.ended_s is not None:
        return f"it has ended at {start.ended_s:.2f} s"
    if start.started_s is not None:
        return f"running since {start.started_s:.2f} s"
    return f"waiting since {start.queued_s:.2f} s"


def _name(start: FirstStart) -> str:
    name = escape(start.name, keep="")
    return name if len(name) <= _MAX_NAME else f"{name[: _MAX_NAME - 3]}..."


def _plot(found: Timeline, columns: int) -> list[str]:
    """`.` while its start is held back, `=` until it is ready, `|` where it is."""
    until_s = found.done_s * (1 + _BAR_SHARE) if found.done_s else found.until_s
    until_s = max(until_s, 0.001)
    names = {one.name: _name(one) for one in found.processes.values()}
    width = max(map(len, names.values()))
    bar = max(_MIN_BAR, columns - width - 12)

    def place(at_s: float | None) -> int:
        return min(bar, round((until_s if at_s is None else at_s) / until_s * bar))

    texts = [f"{'':{width}}  0 s{f'{until_s:.1f} s':>{bar - 3}}"]
    for one in sorted(found.processes.values(), key=lambda one: one.queued_s):
        held, begun, done = place(one.queued_s), place(one.started_s), place(one.done_s)
        text = " " * held + "." * (begun - held) + "=" * (done - begun)
        text += "|" if one.done_s is not None else ""
        at = f"{one.done_s:8.2f} s" if one.done_s is not None else "not ready"
        texts.append(f"{names[one.name]:{width}}  {text:{bar}} {at}")
    return [*texts, "", ". waits   = starts   | ready"]


def _slowest(found: Timeline) -> list[str]:
    own = [(one.own_s, one) for one in found.processes.values() if one.own_s and one.has_facts]
    if not own:
        return []
    own.sort(key=lambda pair: -pair[0])
    return ["from start to ready:", *(f"{own_s:8.2f} s  {_name(one)}" for own_s, one in own)]


def _chain(found: Timeline) -> list[str]:
    """As `systemd-analyze critical-chain`: @ when it was ready, + how long that took."""
    chain = critical_chain(found)
    if not chain:
        return []
    texts = ["critical chain (@ ready, + from its start):"]
    for depth, one in enumerate(chain):
        indent = "" if depth == 0 else f"{'  ' * (depth - 1)}`-"
        waited = f", waited {one.waited_s:.2f} s" if one.waited_s >= 0.005 else ""
        own_s = one.own_s or 0.0  # also if its start was lost with an old file
        texts.append(f"{indent}{_name(one)} @{one.done_s:.2f} s +{own_s:.2f} s{waited}")
    root = chain[-1]
    texts.append(f"{'  ' * (len(chain) - 1)}`-launch file @{root.queued_s:.2f} s")
    return texts


def document(found: Timeline) -> dict[str, Any]:
    """Everything, for programs; times in seconds since the beginning of the run."""
    return {
        "log_dir": found.folder,
        "ready_s": round(found.done_s, 6),
        "is_ready": not found.unready,
        "processes": [_entry(one) for one in found.processes.values()],
        "critical_chain": [one.name for one in critical_chain(found)],
    }


def _entry(start: FirstStart) -> dict[str, Any]:
    times = ("queued_s", "released_s", "started_s", "ready_s", "ended_s", "own_s")
    found = {name: getattr(start, name) for name in times}
    return {
        "name": start.name,
        **{name: None if value is None else round(value, 6) for name, value in found.items()},
        "waited_for": list(start.waited_for),
        "why": start.why or None,
        "has_ready_when": start.has_facts,
    }
