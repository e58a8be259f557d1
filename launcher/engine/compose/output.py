"""Whose line is it: splits the output of a group into that of its members.

Lines of Python have a mark (`launcher.ros.composed.output`). Those of rcl name their logger, and
what follows one in the same block without a name belongs to it. Everything else is the group's.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterator, Sequence

from launcher.model.record import Record

_MARKED = re.compile(rb"\x1e(\d{1,6})([\x1d\x1f])(.*)", re.DOTALL)
_EVENT = b"\x1d"
_TOKEN = re.compile(rb"\x1e\x1d([0-9a-f]{32})\r?")
_LOGGED = re.compile(
    rb"(?:\x1b\[[0-9;]*m)*\[(?:DEBUG|INFO|WARN|ERROR|FATAL)\] \[[0-9.]+\] \[([^\]]+)\]"
)

Tell = Callable[[int, Sequence[str]], None]


class Part(Record):
    """Lines of one member, or of the group; `kept` is how the memory of the group has them."""

    name: str
    prefix: bytes
    lines: bytes
    kept: bytes


class GroupOutput:
    """`names` are (name, prefix) of the members, `own` those of the group.

    `tell(index, words)` is called with what a member does: `exit 0`.
    """

    def __init__(
        self, own: tuple[str, bytes], names: Sequence[tuple[str, bytes]], tell: Tell
    ) -> None:
        self._own = own
        self._names = names
        self._tell = tell
        self._token: str | None = None
        self._loggers: dict[bytes, int | None] = {}
        self.nodes: dict[str, int] = {}

    def begin(self) -> None:
        """Its process starts, and will tell the token of its events before it runs a program."""
        self._token = None

    def parts(self, lines: bytes, *, has_events: bool = True) -> Iterator[Part]:
        """Runs of lines of the same member, in order; `has_events`: not of standard output."""
        pending: list[tuple[bytes, bytes]] = []
        whose: int | None = None
        logged: int | None = None
        for line in lines[:-1].split(b"\n"):
            owner, text, kept = None, line, line
            marked = _MARKED.fullmatch(line) if line[:1] == b"\x1e" else None
            if marked is not None and int(marked[1]) >= len(self._names):
                marked = None
            if has_events and line[:1] == b"\x1e" and (event := self._event_in(line, marked)):
                if pending:
                    yield self._part(whose, pending)
                    pending = []
                event()
                continue
            if marked is not None and marked[2] != _EVENT:
                owner, text = int(marked[1]), marked[3]
                kept = b"[%b] %b" % (self._names[owner][0].encode(), text)
            else:
                found = _LOGGED.match(line)
                if found is not None:
                    logged = self._member_of(found[1])
                owner = logged
            if pending and owner != whose:
                yield self._part(whose, pending)
                pending = []
            whose = owner
            pending.append((text, kept))
        if pending:
            yield self._part(whose, pending)

    def _event_in(self, line: bytes, marked: re.Match[bytes] | None) -> Callable[[], None] | None:
        """What to do for a line that the runner itself has written; None for any other."""
        if self._token is None:
            found = _TOKEN.fullmatch(line)
            return None if found is None else functools.partial(self._learn, found[1].decode())
        if marked is None or marked[2] != _EVENT:
            return None
        token, *words = marked[3].decode(errors="replace").split() or [""]
        return (
            functools.partial(self._event, int(marked[1]), words) if token == self._token else None
        )

    def _learn(self, token: str) -> None:
        self._token = token

    def _part(self, whose: int | None, lines: list[tuple[bytes, bytes]]) -> Part:
        name, prefix = self._own if whose is None else self._names[whose]
        texts, kept = (b"\n".join(some) + b"\n" for some in zip(*lines, strict=True))
        return Part(name, prefix, texts, kept)

    def _member_of(self, logger: bytes) -> int | None:
        """By its logger or one above it; None if several members have it."""
        while logger not in self._loggers and b"." in logger:
            logger = logger.rpartition(b".")[0]
        return self._loggers.get(logger)

    def _event(self, index: int, words: Sequence[str]) -> None:
        if len(words) == 3 and words[0] == "node":
            logger = words[2].encode()
            self._loggers[logger] = index if self._loggers.get(logger, index) == index else None
            self.nodes[words[1]] = index
        elif words:
            self._tell(index, words)
