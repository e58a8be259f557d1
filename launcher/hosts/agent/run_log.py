"""What the parts of the engine have to say, for the operator.

Most of it the operator's replica of a state machine says itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from launcher.base.model.run_events import Resources, RunEvent, Sample
from launcher.run.logs.run_log import RunLog
from launcher.run.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.logs.messages import Line


class AgentRunLog(RunLog):
    """A RunLog without files: warnings go to `warn`, samples of processes to `samples`."""

    def __init__(
        self,
        warn: Callable[[str], None],
        samples: Callable[[Mapping[str, Sample]], None],
    ) -> None:
        self._warn = warn
        self._samples = samples

    def log(
        self, level: str, logger: str, text: str, *, sink: str = "", line: str | None = None
    ) -> None:
        if level != "INFO":
            self._warn(text)

    def report(self, process: Process, line: Line) -> None:
        pass

    def keep_up(self) -> None:
        pass

    def note(
        self,
        event: RunEvent,
        process: Process | None = None,
        at_s: float | None = None,
    ) -> None:
        if isinstance(event, Resources):
            self._samples(event.processes)
