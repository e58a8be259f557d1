"""The verb `snapshot`: the flight recorder writes what it has."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.bag.flight.flight_recorder import FlightRecorderProcess
from launcher.base.run_verb import BadCallError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.part import VerbRequest


def serve(request: VerbRequest) -> None:
    """Answer with the path when it is written; BadCallError."""
    recorder, exchange = request.run.parts.find(FlightRecorderProcess), request.exchange
    if recorder is None:
        hint = "start the run with --record"
        raise BadCallError("wrong-state", "this run is not recorded", hint)

    def done(answer: Mapping[str, Any]) -> None:
        if "error" in answer:
            exchange.fail(BadCallError("wrong-state", f"no snapshot: {answer['error']}"))
        else:
            exchange.reply({"path": answer["snapshot"]}, [f"snapshot in {answer['snapshot']}"])

    recorder.snapshot(request.call.options.get("reason") or "it was requested", done)
