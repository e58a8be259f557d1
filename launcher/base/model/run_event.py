"""The base of all events of a run, their entries in the log, and how their values are shown."""

from __future__ import annotations

from launcher.base.model.events import Outcome, signal_name
from launcher.base.model.record import Record

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any


TYPES: dict[str, type[RunEvent]] = {}  # by the name of the event
SAMPLES = "resources"


class RunEvent(Record):
    """Base of all; `about` is what an entry belongs to: `process`, `run`, or `either`.

    `words` is its text, with the names of fields in place of their values.
    """

    event = ""
    about = "run"
    words = ""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if cls.event:
            TYPES[cls.event] = cls

    @property
    def text(self) -> str:
        """The event in words, which follow the name of the process."""
        kinds = self.__annotations__
        return self.words.format(
            **{name: _shown(kinds[name], getattr(self, name)) for name in self._fields}
        )

    @property
    def is_failure(self) -> bool:
        """Whether a process died unasked, or could not be started."""
        return False

    @property
    def is_sample(self) -> bool:
        """Whether it is one of `resources`, of any version: they come all the time."""
        return self.event == SAMPLES


class UnknownEvent(RunEvent):
    """An event of another version, or with other fields than its type has."""

    event: str
    fields: Mapping[str, Any]

    @property
    def text(self) -> str:
        return " ".join([self.event, *(f"{key}={value}" for key, value in self.fields.items())])


class Entry(Record):
    """An event with its times; `process` and `host` are those of an event about a process.

    `wall_s` is in seconds since 1970, `monotonic_s` on the monotonic clock of the launcher's
    machine; `host` is None for processes of that machine.
    """

    wall_s: float
    monotonic_s: float
    event: RunEvent
    process: str | None = None
    host: str | None = None

    @property
    def item(self) -> dict[str, Any]:
        """The entry for JSON, in which samples are records."""
        subject = {"process": self.process, "host": self.host}
        return {
            "wall_s": self.wall_s,
            "monotonic_s": self.monotonic_s,
            "event": self.event.event,
            **{name: value for name, value in subject.items() if value is not None},
            **fields_of(self.event),
        }

    @property
    def sentence(self) -> str:
        """`a-1: ended (SIGSEGV)`."""
        return self.event.text if self.process is None else f"{self.process}: {self.event.text}"


def fields_of(event: RunEvent) -> Mapping[str, Any]:
    """The fields of the event that its entry has."""
    if isinstance(event, UnknownEvent):
        return event.fields
    cls = type(event)
    return {
        name: value
        for name in cls._fields
        if (value := getattr(event, name)) != getattr(cls, name, _NO_DEFAULT)
    }


_NO_DEFAULT = object()


def exit_text(returncode: int) -> str:
    """`exit code 3` or `SIGKILL`."""
    return str(Outcome(returncode=returncode))


def _shown(kind: str, value: Any) -> object:
    """A value by its type in the source."""
    match kind.partition(" ")[0]:
        case "Names":
            return listed(value)
        case "ReturnCode":
            return exit_text(value)
        case "SignalNumber":
            return signal_name(value)
        case "Seconds":
            return duration(value)
    return value


def listed(names: tuple[str, ...]) -> str:
    """`a, b`, or `none`."""
    return ", ".join(names) or "none"


def duration(seconds: float) -> str:
    """`0.25 s`, with at most two places."""
    return f"{round(seconds, 2):g} s"
