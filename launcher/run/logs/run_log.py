"""Writes the messages of the launcher to the screen and `launch.log`, events to `events.jsonl`."""

from __future__ import annotations

from launcher.output.lines import LogRing
from launcher.output.logs.run_directory import RunDirectory
from launcher.output.stdout import StdoutWriter
from launcher.posix.reactor import Reactor
from launcher.run.processes.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.run_event import RunEvent
    from launcher.language.launch_session import LaunchSession
    from launcher.output.logs.event_log import EventLog
    from launcher.run.logs.messages import Line


class RunLog:
    """`ring` holds the last messages."""

    def __init__(
        self,
        reactor: Reactor,
        screen: StdoutWriter,
        directory: RunDirectory,
        session: LaunchSession | None = None,
    ) -> None:
        self._session = session
        self._reactor = reactor
        self._screen = screen
        self._directory = directory
        self.ring = LogRing()

    def log(
        self, level: str, logger: str, text: str, *, sink: str = "", line: str | None = None
    ) -> None:
        """Write a line to the screen and to `launch.log`, or to one of them (see LogMessage)."""
        text = text if text.isascii() else _encodable(text)
        logger = self._directory.name if logger == "launch" else logger
        formats = None if self._session is None or line is not None else self._session.formats
        if sink != "log":
            usual = f"[{level}] [{logger}]: {text}\n".encode(errors="surrogateescape")
            self.ring.append("", self._reactor.now(), usual)
            wanted = line or ("" if formats is None else formats.screen_line(level, logger, text))
            if wanted:
                self._screen.log_line(wanted)
            elif wanted is not None:
                self._screen.log(level, logger, text)
        if sink != "screen":
            wanted = line or ("" if formats is None else formats.file_line(level, logger, text))
            if wanted:
                self._directory.log_line(wanted)
            elif wanted is not None:
                self._directory.log(level, logger, text)

    def warn(self, text: str) -> None:
        self.log("WARNING", "launch", text)

    def report(self, process: Process, line: Line) -> None:
        self.log(line.level, process.name, line.text)

    def keep_up(self) -> None:
        self._directory.keep_up()

    @property
    def has_files(self) -> bool:
        """Whether the output of processes is kept in files."""
        return self._directory.path is not None

    @property
    def has_lost_output(self) -> bool:
        """Whether output was dropped because the disk is full."""
        return self._screen.dropped_bytes > 0

    @property
    def events(self) -> EventLog:
        return self._directory.events

    def note(
        self,
        event: RunEvent,
        process: Process | None = None,
        at_s: float | None = None,
    ) -> None:
        """Add an entry to `events.jsonl`, which is written at the next idle moment.

        It is about this process, and happened `at_s`, on the monotonic clock; None: just now.
        """
        name = None if process is None else process.name
        host = None if process is None or process.host is None else process.host_name
        if self.events.note(event, at_s, process=name, host=host):
            self._reactor.when_idle(self.events.flush)


def _encodable(text: str) -> str:
    """The text without lone surrogates, except those of `surrogateescape`."""
    try:
        text.encode(errors="surrogateescape")
    except UnicodeEncodeError:
        return text.encode(errors="replace").decode()
    return text
