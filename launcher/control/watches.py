"""The verb `watch`: turns it on and off, and tells what is watched."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from launcher.base.errors import LauncherError
from launcher.base.model.record import replace
from launcher.base.text import count
from launcher.control.peer import Exchange
from launcher.control.verbs import STATE, BadCallError, Call
from launcher.run.process import Process
from launcher.run.run_control import RunControl

_STATES = {"on": True, "off": False}


def serve(
    control: RunControl,
    call: Call,
    exchange: Exchange,
    choose: Callable[[Call], list[Process]],
) -> None:
    """Carry out the request; BadCallError. `choose`: the processes that it names."""
    state = call.options.get(STATE.name)
    if state is not None and state not in _STATES:
        state, call = None, replace(call, names=(state, *call.names))  # it is a name
    chosen = choose(call)
    if state is not None:
        away = [one.name for one in chosen if one.host is not None]
        if call.names and away:
            text = f"{', '.join(away)}: files of processes on other hosts are not watched"
            raise BadCallError("wrong-state", text)
        _turn(control, chosen if call.names else None, on=_STATES[state])
    rows = [_row(control, one) for one in chosen]
    watching = control.watching
    result = {"on": watching.is_on, "launch_files": watching.launch_files, "processes": rows}
    exchange.reply(result, _text(result, is_detailed=bool(call.names) and state is None))


def _turn(control: RunControl, chosen: Sequence[Process] | None, *, on: bool) -> None:
    try:
        control.watching.turn(chosen, on=on)
    except LauncherError as error:
        raise BadCallError("wrong-state", error.message, error.hint) from None


def _row(control: RunControl, process: Process) -> dict[str, Any]:
    return {
        "name": process.name,
        "watched": control.watching.watches(process),
        "files": control.watched_files(process),
    }


def _text(result: dict[str, Any], *, is_detailed: bool) -> list[str]:
    if not result["on"]:
        return ["files are not watched; `watch on` begins"]
    lines = []
    if result["launch_files"]:
        lines.append(f"launch file: {', '.join(result['launch_files'])}")
    for row in result["processes"]:
        lines.append(f"{row['name']}: {_files(row)}")
        if is_detailed:
            lines += [f"  {path}" for path in row["files"] or ()]
    return lines


def _files(row: dict[str, Any]) -> str:
    if not row["watched"]:
        return "not watched"
    return "watched" if row["files"] is None else count(len(row["files"]), "file")
