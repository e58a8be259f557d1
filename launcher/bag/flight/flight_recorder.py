"""The flight recorder of a run: its process is launcher.bag.ros.flight."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.bag.flight.recording import settings_of
from launcher.base.model.run_events import SnapshotWritten
from launcher.base.run_verb import BadCallError
from launcher.run.helpers.answering_process import AnsweringProcess
from launcher.run.part import Part

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.helpers.answering_process import Done
    from launcher.run.part import VerbRequest
    from launcher.run.run import Run

GOODBYE_S = 30.0  # to write what it has in memory to a slow disk
MODULE = "launcher.bag.ros.flight"


class FlightRecorderProcess(Part):
    """Starts it as the options say, and passes on requests and answers."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        assert run.socket is not None
        self._log = run.log
        self._process = AnsweringProcess(
            run,
            MODULE,
            settings_of(run.options, run.log_dir, run.socket),
            name="the flight recorder",
            without="nothing is recorded",
            goodbye_s=GOODBYE_S,
            on_message=self._heard,
        )

    @property
    def pid(self) -> int | None:
        return self._process.pid

    def begin(self) -> None:
        self._process.start()

    def snapshot(self, reason: str, done: Done, *, of_fault: bool = False) -> None:
        """Write a snapshot; `done` is called with `{"snapshot": PATH}` or `{"error": TEXT}`.

        One `of_fault` has what follows, too, and is that which faults have by themselves.
        """
        self._process.ask({"snapshot": reason, "of_fault": of_fault}, done)

    def _heard(self, answer: dict[str, Any]) -> None:
        if "note" in answer:
            self._log.warn(f"recording: {answer['note']}")
            return
        if "snapshot" in answer:
            text = f"snapshot in {answer['snapshot']}: {answer['reason']}"
            self._log.log("INFO", "launch", text)
            self._log.note(SnapshotWritten(answer["snapshot"], answer["reason"]))
        elif "error" in answer:
            self._log.warn(f"no snapshot: {answer['error']}")
        for number in answer.get("asked", ()):
            self._process.answer(number, answer)

    def close(self) -> None:
        """Let it write what it is about to write, and wait for its exit."""
        self._process.order({"end": True})
        self._process.close()


def serve(request: VerbRequest) -> None:
    """The verb `snapshot`: the path when it is written; BadCallError."""
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
