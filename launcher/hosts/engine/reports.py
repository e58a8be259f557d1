"""Events of state machines as JSON, for reports of a host."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.base.model.events import Outcome
from launcher.run.processes.machine_events import (
    Exited,
    MachineCommand,
    MachineEvent,
    SignalSent,
    SpawnError,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_OF_OUTCOME = ("returncode", "core_dumped", "out_of_memory")


def encode_event(event: MachineEvent) -> dict[str, Any]:
    match event:
        case MachineCommand():
            return {"command": event.name}
        case SpawnError(errno=number, what=what):
            return {"errno": number, "what": what}
        case SignalSent(signum=signum, by_user=by_user):
            return {"signal": int(signum), "by_user": by_user}
        case Exited(outcome=outcome):
            return {name: getattr(outcome, name) for name in _OF_OUTCOME}


def decode_event(content: Mapping[str, Any]) -> MachineEvent:
    """ValueError or KeyError for what is no event."""
    if "command" in content:
        return MachineCommand[content["command"]]
    if "errno" in content:
        return SpawnError(int(content["errno"]), str(content["what"]))
    if "signal" in content:
        return SignalSent(int(content["signal"]), by_user=bool(content["by_user"]))
    return Exited(Outcome(**{name: content[name] for name in _OF_OUTCOME}))
