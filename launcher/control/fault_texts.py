"""Faults of a watched run in words; a fault is an object of docs/reference/faults.md."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence

from launcher.base.model.fault_events import with_cause
from launcher.base.text import escape, several

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    Fault = Mapping[str, Any]

# By the change that a line of `faults -f` reports: the field with its time.
_TIMES = {"suspected": "first_s", "confirmed": "confirmed_s", "healed": "healed_s"}
_PRESENT, _UPDATED, _FORGOTTEN = "present", "updated", "forgotten"
# What an update must have changed to be a line: measured values change all the time.
_WORTH_A_LINE = ("state", "cause", "follows", "acknowledged", "muted")
NO_FAULT = "no fault"
NOT_WATCHING = "the watcher is not running, or does not respond: faults of now are not known"
_ORDER = {"active": 0, "suspected": 1, "healed": 2}


def is_reported(fault: Fault) -> bool:
    """Whether it is active and not muted."""
    return fault["state"] == "active" and fault["muted"] is None


def is_gone(item: Fault) -> bool:
    """Whether it leaves the table: a suspicion that was never confirmed, or one of long ago."""
    change = item["change"]
    return change == _FORGOTTEN or (change == "dismissed" and not item["count"])


def state_word(fault: Fault) -> str:
    """Its state; of an active one also `muted` or `acknowledged`."""
    if fault["state"] == "active":
        return next((word for word in ("muted", "acknowledged") if fault[word]), "active")
    return str(fault["state"])


def clock(wall_s: float, now_s: float | None = None) -> str:
    """`12:00:05`, with the date if that is not the day of `now_s` (default: today)."""
    at, now = time.localtime(wall_s), time.localtime(now_s)
    form = "%H:%M:%S" if at[:3] == now[:3] else "%Y-%m-%d %H:%M:%S"
    return time.strftime(form, at)


def since(fault: Fault) -> str:
    """`12:00:05`; of one that is healed `12:00:05 to 12:00:09`."""
    end_s = fault["healed_s"]
    return clock(fault["first_s"]) + (f" to {clock(end_s)}" if end_s is not None else "")


def arranged(faults: Iterable[Fault]) -> list[tuple[int, Fault]]:
    """(depth, fault): active ones first, and each behind the one that it follows from."""
    known = {fault["fault"]: fault for fault in faults}
    behind: dict[str | None, list[Fault]] = {}
    for fault in known.values():
        root = fault["follows"] if fault["follows"] in known else None
        behind.setdefault(root, []).append(fault)
    found: dict[str, tuple[int, Fault]] = {}

    def add(those: Sequence[Fault], depth: int) -> None:
        for fault in sorted(those, key=_place):
            if fault["fault"] not in found:
                found[fault["fault"]] = depth, fault
                add(behind.get(fault["fault"], ()), depth + 1)

    add(behind.get(None, ()), 0)
    add(list(known.values()), 0)  # those that follow from each other
    return list(found.values())


def _place(fault: Fault) -> tuple[int, float]:
    first_s = fault["first_s"]
    healed = fault["state"] == "healed"
    return _ORDER.get(fault["state"], len(_ORDER)), -first_s if healed else first_s


def fault_line(fault: Fault) -> str:
    """One fault, or one item of `faults -f`, on a line."""
    change = fault.get("change", _PRESENT)
    at_s = fault.get(_TIMES.get(change, "last_s" if change == _UPDATED else "first_s"))
    word = change if change in _TIMES or change == "dismissed" else state_word(fault)
    seen = with_cause(fault["seen"], fault["cause"])
    follows = f" (follows from '{fault['follows']}')" if fault["follows"] else ""
    text = f"{clock(at_s or fault['first_s'])} {word}: {fault['fault']}: {seen}"
    return escape(f"{text}{follows}", keep="")


class FaultLines:
    """The lines of one stream of `faults -f`."""

    def __init__(self) -> None:
        self._shown: dict[str, tuple[Any, ...]] = {}

    def of(self, item: Fault) -> str | None:
        """The line of an item; None where only measured values have changed."""
        if "dropped" in item:
            return f"({item['dropped']} changes were not read in time)"
        if item["change"] == _FORGOTTEN:
            self._shown.pop(item["fault"], None)
            return None
        before = self._shown.get(item["fault"])
        now = self._shown[item["fault"]] = tuple(item[name] for name in _WORTH_A_LINE)
        return None if before == now and item["change"] == _UPDATED else fault_line(item)


def mute_lines(mutes: Iterable[Mapping[str, Any]], faults: Iterable[Fault]) -> list[str]:
    """A line for each mute in force of what is not active: nothing else shows it."""
    shown = {fault["fault"] for fault in faults if fault["state"] == "active"}
    return [
        escape(f"muted: {one['fault']}{_mute_text(one)}", keep="")
        for one in mutes
        if one["fault"] not in shown
    ]


def _mute_text(mute: Mapping[str, Any]) -> str:
    until = "" if mute["until_s"] is None else f" until {clock(mute['until_s'])}"
    return until + (f": {mute['reason']}" if mute["reason"] else "")


def reason_text(fault: Fault) -> str:
    """Until when an active one is muted, and why; or why it is acknowledged."""
    if fault["state"] != "active":
        return ""
    if fault["muted"] is not None:
        return _mute_text(fault["muted"]).lstrip(": ")
    return (fault["acknowledged"] or {}).get("reason") or ""


def left_lines(left: Iterable[Mapping[str, Any]]) -> list[str]:
    """What a watched run leaves to smoke, one line for each reason; `--json` has all names."""
    names: dict[str, list[str]] = {}
    for one in left:
        names.setdefault(str(one["why"]), []).append(str(one["expectation"]))
    return [
        escape(f"left to smoke, {why}: {several(those)}", keep="") for why, those in names.items()
    ]
