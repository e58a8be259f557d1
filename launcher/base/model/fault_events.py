"""Events of a watched run; as `run_events`."""

from __future__ import annotations

from launcher.base.model.run_event import RunEvent

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.run_events import Count, Seconds


class FaultConfirmed(RunEvent):
    """An expectation of a watched run does not hold ([faults](faults.md)).

    fault: its name
    seen: what was seen instead
    incident: number of the incident that it belongs to
    cause: why, in a sentence; null if no rule explains it
    follows: the fault that it follows from
    """

    event, about = "fault", "either"
    fault: str
    seen: str
    incident: Count
    cause: str | None = None
    follows: str | None = None

    @property
    def text(self) -> str:
        cause = f"; {self.cause}" if self.cause else ""
        return f"fault '{self.fault}': {self.seen}{cause}"


class FaultHealed(RunEvent):
    """It holds again.

    fault: its name
    active_s: how long it did not
    incident: number of the incident
    """

    event, about = "fault healed", "either"
    words = "fault '{fault}' is healed, after {active_s}"
    fault: str
    active_s: Seconds
    incident: Count
