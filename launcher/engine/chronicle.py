"""Chronicle: what the supervisor says, on the screen, in the log and in the journal."""

from __future__ import annotations

from launcher.engine.journal import Journal
from launcher.engine.process import Process
from launcher.engine.reactor import Reactor
from launcher.engine.ring import LogRing
from launcher.engine.runfolder import RunFolder
from launcher.engine.screen import Screen

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.engine.report import Line


class Chronicle:
    """One voice for a run; `ring` holds the last lines of its own."""

    def __init__(self, reactor: Reactor, screen: Screen, folder: RunFolder) -> None:
        self._reactor = reactor
        self._screen = screen
        self._folder = folder
        self.ring = LogRing()

    def say(self, level: str, logger: str, text: str) -> None:
        """A line of our own, on the screen and in the log."""
        text = text if text.isascii() else _encodable(text)
        line = f"[{level}] [{logger}]: {text}\n".encode(errors="surrogateescape")
        self.ring.append("", self._reactor.now(), line)
        self._screen.log(level, logger, text)
        self._folder.log(level, logger, text)

    def warn(self, text: str) -> None:
        """A warning of the launcher itself."""
        self.say("WARNING", "launch", text)

    def tell(self, process: Process, line: Line) -> None:
        """A line about a process."""
        self.say(line.level, process.name, line.text)

    def keep_up(self) -> None:
        """See whether the files are still there; now and then."""
        self._folder.keep_up()

    @property
    def has_lost_output(self) -> bool:
        """Whether the screen's disk had no room for something."""
        return self._screen.dropped_bytes > 0

    @property
    def journal(self) -> Journal:
        """Where the entries go."""
        return self._folder.journal

    def note(self, event: str, process: Process | None = None, **details: object) -> None:
        """An entry of the journal, written when this pass of the loop is done."""
        journal = self._folder.journal
        if journal.is_empty:
            self._reactor.call_later(0, journal.flush)
        if process is not None:
            details = {"process": process.name, **details}
        journal.note(event, **details)


def _encodable(text: str) -> str:
    """The text, in which bytes that were no UTF-8 stay, and halves of characters do not."""
    try:
        text.encode(errors="surrogateescape")
    except UnicodeEncodeError:
        return text.encode(errors="replace").decode()
    return text
