"""The verb `snapshot`: the flight recorder writes what it has."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.control.peer import Exchange
from launcher.control.verbs import BadCallError, Call
from launcher.run.run_control import RunControl

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def answer(control: RunControl, call: Call, exchange: Exchange) -> None:
    """Answer with the path when it is written; BadCallError."""
    if control.recorder is None:
        hint = "start the run with --record"
        raise BadCallError("wrong-state", "this run is not recorded", hint)

    def done(answer: Mapping[str, Any]) -> None:
        if "error" in answer:
            exchange.fail(BadCallError("wrong-state", f"no snapshot: {answer['error']}"))
        else:
            exchange.reply({"path": answer["snapshot"]}, [f"snapshot in {answer['snapshot']}"])

    control.recorder.snapshot(call.options.get("reason") or "it was requested", done)
