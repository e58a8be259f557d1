"""Whose line is it: splits the output of a group into that of its members.

What Python writes comes in frames (`launcher.ros.composed.member_output`). Lines of rcl name their
logger, and what follows one in the same block without a name belongs to it. Everything else is the
group's. What members do comes in messages, on a separate descriptor.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

from launcher.base.model.record import Record
from launcher.output.lines import CUT_MARK, LINE_LIMIT, LineBuffer

_RS, _GOES_ON, _ENDS = b"\x1e", b"\x1d", b"\x1f"
_TOKEN = re.compile(rb"token ([0-9a-f]{16})")
_EXIT = re.compile(rb"(\d{1,6}) exit (-?\d{1,6})")
_NODE = re.compile(rb"(\d{1,6}) node (\S+) (\S+)")
_LOGGED = re.compile(
    rb"(?:\x1b\[[0-9;]*m)*\[(?:DEBUG|INFO|WARN|ERROR|FATAL)\] \[[0-9.]+\] \[([^\]]+)\]"
)

Report = Callable[[int, int], None]


class OutputPart(Record):
    """Lines of one member, or of the group; `kept` is how the memory of the group has them."""

    name: str
    prefix: bytes
    lines: bytes
    kept: bytes


class FrameBuffer(LineBuffer):
    """Splits a stream with frames into lines; one of a member begins with `mark INDEX US`.

    A frame `mark INDEX US TEXT` ends a line of that member, with GS the line goes on. It is written
    at once, but anywhere: also within a line that something else writes in pieces, which goes on
    behind the frame. `mark` is known before anything else can come.
    """

    def __init__(self) -> None:
        super().__init__()
        self.mark = b""
        self._frame: re.Pattern[bytes] | None = None
        self._rest = b""  # the beginning of a frame
        self._begun: dict[bytes, bytes] = {}  # member -> its line so far

    def learn(self, token: bytes) -> None:
        self.mark = _RS + token
        self._frame = re.compile(re.escape(self.mark) + rb"(\d{1,6})([\x1d\x1f])([^\n]*)\n")

    def feed(self, chunk: bytes) -> tuple[bytes, int]:
        if self._frame is None:
            return super().feed(chunk)
        data, at, lines = self._rest + chunk, 0, []
        for found in self._frame.finditer(data):
            lines += [self._plain(data[at : found.start()]), self._line(*found.groups())]
            at = found.end()
        end = at + self._unfinished(data[at:])
        self._rest = data[end:]
        return b"".join([*lines, self._plain(data[at:end])]), 0

    def _plain(self, data: bytes) -> bytes:
        return super().feed(data)[0] if data else b""

    def _line(self, index: bytes, kind: bytes, text: bytes) -> bytes:
        """The line of a member that a frame ends; empty if it goes on."""
        text = self._begun.pop(index, b"") + text
        if len(text) > LINE_LIMIT:
            text = text[:LINE_LIMIT] + CUT_MARK
        if kind == _ENDS:
            return b"%b%b%b%b\n" % (self.mark, index, _ENDS, text)
        self._begun[index] = text
        return b""

    def _unfinished(self, data: bytes) -> int:
        """Where a frame begins, or may begin, whose end was not read yet."""
        begin = data.rfind(self.mark)
        if begin >= 0 and b"\n" not in data[begin:]:
            return begin
        begin = data.rfind(_RS)
        return begin if begin >= 0 and self.mark.startswith(data[begin:]) else len(data)

    def take_partial(self) -> tuple[bytes, int]:
        rest, self._rest = self._rest, b""
        cut_off = self._frame and self._frame.fullmatch(rest + b"\n")
        if cut_off:
            self._line(cut_off[1], _GOES_ON, cut_off[3])
            rest = b""
        begun = [self._line(index, _ENDS, b"") for index in list(self._begun)]
        plain, shown = super().take_partial()
        return b"".join([plain, *begun, rest and rest + b"\n"]), shown


class GroupOutput:
    """`names` are (name, prefix) of the members, `own` those of the group.

    `report(index, code)` is called when a member has ended.
    """

    def __init__(
        self, own: tuple[str, bytes], names: Sequence[tuple[str, bytes]], report: Report
    ) -> None:
        self._own = own
        self._names = names
        self._report = report
        self._buffers: list[FrameBuffer] = []  # of the present life
        self._ends: list[tuple[int, int]] = []  # (member, return code)
        self._loggers: dict[bytes, int | None] = {}
        self.nodes: dict[str, int] = {}

    def begin(self) -> None:
        """Its process starts, and will send its token before it runs a program."""
        self._buffers = []

    def buffer(self) -> FrameBuffer:
        """For one of its streams."""
        self._buffers.append(FrameBuffer())
        return self._buffers[-1]

    def take(self, message: bytes) -> None:
        """A message of the process: its token, a new node, or the end of a member."""
        if found := _TOKEN.fullmatch(message):
            for buffer in self._buffers:
                buffer.learn(found[1])
        elif (found := _EXIT.fullmatch(message)) and int(found[1]) < len(self._names):
            self._ends.append((int(found[1]), int(found[2])))
        elif found := _NODE.fullmatch(message):
            self._learn(int(found[1]), found[2].decode(), found[3])

    def _learn(self, index: int, node: str, logger: bytes) -> None:
        self._loggers[logger] = index if self._loggers.get(logger, index) == index else None
        self.nodes[node] = index

    @property
    def has_ends(self) -> bool:
        """Whether members have ended that were not reported yet."""
        return bool(self._ends)

    def settle(self, read: Callable[[], object]) -> None:
        """Report members that have ended, behind what they have written: `read` reads all that."""
        while self._ends:
            ends, self._ends = self._ends, []
            read()
            for index, code in ends:
                self._report(index, code)

    def parts(self, lines: bytes, mark: bytes) -> Iterator[OutputPart]:
        """Runs of lines of the same member, in order."""
        pending: list[tuple[bytes, bytes]] = []
        whose: int | None = None
        logged: int | None = None
        for line in lines[:-1].split(b"\n"):
            own = self._own_line(line, mark) if line[:1] == _RS else None
            if own is None:
                found = _LOGGED.match(line)
                logged = logged if found is None else self._member_of(found[1])
            owner, text, kept = own or (logged, line, line)
            if pending and owner != whose:
                yield self._part(whose, pending)
                pending = []
            whose = owner
            pending.append((text, kept))
        if pending:
            yield self._part(whose, pending)

    def _own_line(self, line: bytes, mark: bytes) -> tuple[int, bytes, bytes] | None:
        """(member, text, text with its name) of a line that a `FrameBuffer` has marked."""
        index, is_marked, text = line[len(mark) :].partition(_ENDS)
        if not is_marked or not mark or not line.startswith(mark) or not index.isdigit():
            return None
        if int(index) >= len(self._names):
            return None
        return int(index), text, b"[%b] %b" % (self._names[int(index)][0].encode(), text)

    def _part(self, whose: int | None, lines: list[tuple[bytes, bytes]]) -> OutputPart:
        name, prefix = self._own if whose is None else self._names[whose]
        texts, kept = (b"\n".join(some) + b"\n" for some in zip(*lines, strict=True))
        return OutputPart(name, prefix, texts, kept)

    def _member_of(self, logger: bytes) -> int | None:
        """By its logger or one above it; None if several members have it."""
        while logger not in self._loggers and b"." in logger:
            logger = logger.rpartition(b".")[0]
        return self._loggers.get(logger)
