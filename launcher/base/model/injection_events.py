"""Events of faults that were injected on purpose; see `run_events`."""

from __future__ import annotations

from launcher.base.model.run_event import RunEvent

TYPE_CHECKING = False
if TYPE_CHECKING:
    Seconds = float


class InjectionBegan(RunEvent):
    """A fault was injected on purpose ([inject](../guides/inject.md)), into the process if any.

    what: as it was requested: `slow 4`
    for_s: how long it will last at most; null if it happens at once
    """

    event, about = "injection", "either"
    what: str
    for_s: Seconds | None

    @property
    def text(self) -> str:
        return f"injected: {self.what}" + ("" if self.for_s is None else f" for {self.for_s:g} s")


class InjectionEnded(RunEvent):
    """An injected fault is over, and everything is as before.

    what: as it was requested
    lasted_s: how long it was in force
    why: what ended it: `its time is over`, `requested`, or what happened to the process
    """

    event, about = "injection ended", "either"
    words = "injection over: {what} ({why})"
    what: str
    lasted_s: Seconds
    why: str
