"""What a run will start, for the process that has started the launcher to judge it: `smoke`.

That process names a socket in the variable `LAUNCHER_FORECAST`. When the launch file has been
evaluated, a line of JSON is written to it, and the run begins only after an answer.
"""

from __future__ import annotations

import os
import socket

from launcher.base import strict_json
from launcher.base.model.events import LoadRequest
from launcher.language.interpreter.unvisited import EventTime
from launcher.run.requests.process_selection import ProcessNames

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.launch.launch_core import LaunchCore

_AT_ONCE = EventTime(time_s=0.0)


def is_accepted(descriptor: int, core: LaunchCore) -> bool:
    """Write what the launch file will start; whether the run may begin."""
    with socket.socket(fileno=descriptor) as judge:
        try:
            judge.sendall(strict_json.packed(document(core)).encode() + b"\n")
            return bool(judge.recv(1))
        except OSError:
            return False  # it has gone


def take_descriptor(word: str) -> int:
    """The descriptor that the variable names, which no program that is started inherits."""
    descriptor = int(word)
    os.set_inheritable(descriptor, False)
    return descriptor


def document(core: LaunchCore) -> dict[str, Any]:
    """What the static part starts, and what may follow as far as that is known."""
    later = core.later()
    numbered = len(core.starts)
    expected = [(ProcessNames.of(spec), _AT_ONCE) for spec in core.starts]
    for one in later.processes:
        if one.is_likely:
            numbered += 1
            named = ProcessNames.of(one.spec)
            expected.append((_numbered(named, numbered), one.moment))
    return {
        "is_certain": later.is_complete,
        "processes": [
            {
                "name": one.name,
                "label": one.label,
                "nodes": one.nodes,
                "namespace": one.namespace,
                "moment": _moment(moment),
            }
            for one, moment in expected
        ],
        "components": [_component(load) for load in (*core.loads, *later.loads)],
        "conditions": [_moment(one.moment) for one in later.processes if not one.is_likely],
    }


def _numbered(names: ProcessNames, number: int) -> ProcessNames:
    return ProcessNames(f"{names.label}-{number}", names.label, names.nodes, names.namespace)


def _moment(moment: EventTime) -> dict[str, Any]:
    return {"time_s": moment.time_s, "cause": moment.cause}


def _component(load: LoadRequest) -> str | None:
    """The full name of its node; None if the component names it itself."""
    if load.name is None:
        return None
    return f"{(load.namespace or '').rstrip('/')}/{load.name}"
