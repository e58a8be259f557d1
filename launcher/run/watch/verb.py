"""The verb `watch`: turns it on and off, and shows what is watched."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from launcher.base.errors import LauncherError
from launcher.base.run_verb import BadCallError
from launcher.base.text import count
from launcher.run.part_verbs import STATE
from launcher.run.processes.process import Process
from launcher.run.watch.watching import Watching

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.part import VerbRequest

_STATES = {"on": True, "off": False}


def serve(request: VerbRequest) -> None:
    """Carry out the request; BadCallError."""
    call, watching = request.call, request.run.parts.need(Watching)
    names = call.names
    state = call.options.get(STATE.name)
    if state is not None and state not in _STATES:
        names, state = (state, *names), None  # it is a name
    chosen = request.chosen(names)
    if state is not None:
        away = [one.name for one in chosen if one.host is not None]
        if names and away:
            text = f"{', '.join(away)}: files of processes on other hosts are not watched"
            raise BadCallError("wrong-state", text)
        _turn(watching, chosen if names else None, on=_STATES[state])
    rows = [_row(watching, one) for one in chosen]
    result = {"on": watching.is_on, "launch_files": watching.launch_files, "processes": rows}
    request.exchange.reply(result, _text(result, is_detailed=bool(names) and state is None))


def _turn(watching: Watching, chosen: Sequence[Process] | None, *, on: bool) -> None:
    try:
        watching.turn(chosen, on=on)
    except LauncherError as error:
        raise BadCallError("wrong-state", error.message, error.hint) from None


def _row(watching: Watching, process: Process) -> dict[str, Any]:
    return {
        "name": process.name,
        "watched": watching.watches(process),
        "files": watching.files(process),
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
