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
        if self.follows is not None:
            return f"fault '{self.fault}' follows from '{self.follows}': {self.seen}"
        return f"fault '{self.fault}': {with_cause(self.seen, self.cause)}"


def with_cause(seen: str, cause: str | None) -> str:
    """What was seen, and why; the cause alone if that says both."""
    if cause is None or cause in seen:
        return seen
    return cause if seen in cause else f"{seen}; {cause}"


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


class ActionTaken(RunEvent):
    """Something was done for a fault ([actions](faults.md#actions)).

    fault: its name
    action: what, as `restart robot_2`
    ok: whether it has succeeded, in time
    detail: what came of it
    """

    event, about = "fault action", "run"
    fault: str
    action: str
    ok: bool
    detail: str

    @property
    def text(self) -> str:
        how = "" if self.ok else "failed: "
        return f"{self.action}, for fault '{self.fault}': {how}{self.detail}"
