"""Lines on the screen in another form than that of ROS 2: `compact`, or a user's template.

A line of a node is split into severity, time, name and message, by the format that the node has
(RCUTILS_CONSOLE_OUTPUT_FORMAT in its environment), and is put together again. Log files, and
requests for lines, have the lines as they were.
"""

from __future__ import annotations

import functools
import re
import time
from collections.abc import Callable, Mapping

from launcher.base.model.spec import ProcessSpec
from launcher.base.text import suggest
from launcher.output.filters import INFO, LEVELS, level_of

DEFAULT, COMPACT = "default", "compact"
NODE_FORMAT = "[{severity}] [{time}] [{name}]: {message}"  # of rcutils
NS = 1_000_000_000
MAX_HEADS = 1000  # that are kept: a node may log under any number of names
MAX_NAME = 20  # columns of the names in compact lines; longer ones are not aligned

_RESET = b"\x1b[0m"
_SGR = rb"\x1b\[[0-9;:]*m"
_TOKEN = re.compile(r"\{(\w+)\}")
_BRACED = re.compile(r"\{(\w+)([^\w{}][^{}]*)?(\}?)")
_LETTERS = {b"DEBUG": b"D", b"INFO": b"I", b"WARN": b"W", b"ERROR": b"E", b"FATAL": b"F"}
_COLOURS = {
    b"DEBUG": b"\x1b[2m",
    b"WARN": b"\x1b[33m",
    b"ERROR": b"\x1b[31m",
    b"FATAL": b"\x1b[1;31m",
}
_INDENTED = (b" ", b"\t")
_TRACEBACK = b"Traceback (most recent call last):"
# What a token of a node's format looks like.
_PATTERNS = {
    "severity": rb"DEBUG|INFO|WARN|ERROR|FATAL",
    "time": rb"\d{1,18}\.\d+",
    "time_as_nanoseconds": rb"\d{1,27}",
    "date_time_with_ms": rb"\d+-\d+-\d+ [\d:.]+",
    "name": rb"\S*?",
    "message": rb".*?",
    "function_name": rb".*?",
    "file_name": rb".*?",
    "line_number": rb"\d+",
}
_OF_NODES_ONLY = ("function_name", "file_name", "line_number")


class OutputMessage:
    """A line of a process, or one of the launcher. `at_ns` is since 1970."""

    __slots__ = ("at_ns", "name", "severity", "text")

    def __init__(self, severity: bytes, at_ns: int, name: bytes, text: bytes) -> None:
        self.severity = severity
        self.at_ns = at_ns
        self.name = name
        self.text = text


class LineSource:
    """A process whose lines are shown; `label` is its short name, `begin` its colour."""

    __slots__ = ("begin", "label", "match", "name")

    def __init__(self, name: bytes, label: bytes, begin: bytes, node_format: str) -> None:
        self.name = name
        self.label = label
        self.begin = begin
        self.match = _parser(node_format)


class LineFormat:
    """Formats blocks of whole lines. `name` is as in `check`, and not the default.

    `sources` are the processes by their prefixes, each with its colour.
    """

    def __init__(
        self, name: str, sources: Mapping[bytes, tuple[ProcessSpec, bytes]], *, colour: bool
    ) -> None:
        self.name = name
        self._specs = sources
        self._colour = colour
        self._template = None if name == COMPACT else _template(name)
        self._sources: dict[bytes, LineSource] = {}
        self._width = 0
        self._heads: dict[tuple[bytes, bytes, bytes], tuple[bytes, int]] = {}
        self._second = -1
        self._clock = b""
        # Of the last line: its stream, blanks for the columns before its text, its colour.
        self._last: object = None
        self._indent = b""
        self._paint = b""
        self._in_traceback: set[object] = set()

    # ---- blocks

    def lines(self, prefix: bytes, stream: object, lines: bytes) -> bytes:
        """Whole lines of the process with this prefix."""
        source = self._sources.get(prefix) or self._source(prefix)
        now = time.time_ns() - int(getattr(stream, "ago_s", 0.0) * 1e9)
        shown: list[bytes] = []
        has_head = False  # of a message in this block
        for line in lines[:-1].split(b"\n"):
            message = source.match(line, now)
            if message is not None:
                has_head = True
                self._in_traceback.discard(stream)
            elif self._continues(stream, line, has_head=has_head) and self._last is stream:
                shown.append(self._indent + self._painted(line))
                continue
            else:
                message = OutputMessage(_severity(line), now, b"", line)
            shown.append(self._line(source, message))
            self._last = stream
        return b"\n".join(shown) + b"\n"

    def _continues(self, stream: object, line: bytes, *, has_head: bool) -> bool:
        """Whether a line without a head belongs to the one before it."""
        if line.startswith(_TRACEBACK):
            self._in_traceback.add(stream)
            return has_head
        if line.startswith(_INDENTED):
            return True
        was_in_traceback = stream in self._in_traceback
        self._in_traceback.discard(stream)
        return has_head or was_in_traceback

    def own(self, level: str, logger: str, text: bytes) -> bytes:
        """A line of the launcher, or several, of which the first gets a head."""
        self.interrupt()
        name = logger.encode(errors="surrogateescape")
        source = self._named(name)
        severity = {"WARNING": b"WARN", "CRITICAL": b"FATAL"}.get(level) or level.encode()
        first, newline, rest = text.partition(b"\n")
        return (
            self._line(source, OutputMessage(severity, time.time_ns(), b"", first)) + newline + rest
        )

    def interrupt(self) -> None:
        """Another line was written in between."""
        self._last = None

    def head(self, prefix: bytes, stream: object) -> bytes:
        """What precedes an unfinished line."""
        source = self._sources.get(prefix) or self._source(prefix)
        self._last = stream
        return self._coloured_head(source, OutputMessage(b"INFO", time.time_ns(), b"", b""))

    # ---- lines

    def _line(self, source: LineSource, message: OutputMessage) -> bytes:
        head = self._coloured_head(source, message)
        self._paint = _COLOURS.get(message.severity, b"") if self._colour else b""
        after = b"" if self._template is None else self._filled(self._template[1], source, message)
        return head + self._painted(message.text) + after

    def _painted(self, text: bytes) -> bytes:
        return self._paint + text + _RESET if self._paint else text

    def _coloured_head(self, source: LineSource, message: OutputMessage) -> bytes:
        if self._template is None:
            return self._compact(source, message)
        head = self._filled(self._template[0], source, message)
        self._indent = b" " * len(head.decode(errors="replace"))
        return head

    def _compact(self, source: LineSource, message: OutputMessage) -> bytes:
        """`03:04:18.902 robot_1 `, with a letter for the level where there are no colours."""
        key = source.name, message.severity, message.name
        known = self._heads.get(key)
        if known is None:
            if len(self._heads) > MAX_HEADS:
                self._heads.clear()
            known = self._heads[key] = self._head_of(source, message)
        clock = self._clock_of(message.at_ns)
        self._indent = b" " * (len(clock) + known[1])
        return clock + known[0]

    def _head_of(self, source: LineSource, message: OutputMessage) -> tuple[bytes, int]:
        """What stands between time and text, and its columns."""
        name, logger = source.label, message.name
        letter = b"" if self._colour else _LETTERS.get(message.severity, b"?") + b" "
        is_own = logger in (b"", name, source.name) or logger.endswith(b"." + name)
        rest = b" " * (self._width - len(name)) + (b" " if is_own else b" " + logger + b": ")
        columns = len((b" " + letter + name + rest).decode(errors="replace"))
        if source.begin:
            name = source.begin + name + _RESET
        return b" " + letter + name + rest, columns

    def _filled(self, part: str, source: LineSource, message: OutputMessage) -> bytes:
        """This part of the template."""

        def value(found: re.Match[str]) -> str:
            match found[1]:
                case "severity":
                    return message.severity.decode()
                case "name":
                    return (message.name or source.label).decode(errors="replace")
                case "process":
                    return source.name.decode(errors="replace")
                case "clock":
                    return self._clock_of(message.at_ns).decode()
                case "time":
                    return "{}.{:09}".format(*divmod(message.at_ns, NS))
                case "time_as_nanoseconds":
                    return str(message.at_ns)
            return self._clock_of(message.at_ns, date=True).decode()

        return _TOKEN.sub(value, part).encode(errors="replace")

    def _clock_of(self, at_ns: int, *, date: bool = False) -> bytes:
        """`03:04:18.902`, or `2026-11-21 03:04:18.902`."""
        second, rest_ns = divmod(at_ns, NS)
        if second != self._second:
            try:
                text = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(second))
            except (OverflowError, ValueError, OSError):
                return b"%d" % second
            self._clock = text.encode()
            self._second = second
        return b"%b.%03d" % (self._clock if date else self._clock[-8:], rest_ns // 1_000_000)

    # ---- sources

    def _source(self, prefix: bytes) -> LineSource:
        spec, colour = self._specs[prefix]
        labels = [one.label for one, _ in self._specs.values()]
        for one in labels:
            self._width = max(self._width, min(MAX_NAME, len(one)))
        self._heads.clear()
        label = spec.label if labels.count(spec.label) == 1 else spec.name
        node_format = spec.env.get("RCUTILS_CONSOLE_OUTPUT_FORMAT") or NODE_FORMAT
        source = LineSource(_bytes(spec.name), _bytes(label), colour, node_format)
        self._sources[prefix] = source
        return source

    def _named(self, name: bytes) -> LineSource:
        """The process with this name, or the launcher itself."""
        for prefix, (spec, _) in self._specs.items():
            if _bytes(spec.name) == name:
                return self._sources.get(prefix) or self._source(prefix)
        return LineSource(name, name, b"", NODE_FORMAT)


def _severity(line: bytes) -> bytes:
    """The level that a line without the head of a node names; INFO if it names none."""
    if line.startswith(_TRACEBACK):
        return b"ERROR"
    level = level_of(line)
    return LEVELS[INFO if level is None else level].encode()


def _bytes(text: str) -> bytes:
    return text.encode(errors="surrogateescape")


# ---- formats


def check(name: str) -> str:
    """The name of a format, or a template; ValueError."""
    if name not in (DEFAULT, COMPACT):
        _template(name)
    return name


_OURS = ("severity", "time", "time_as_nanoseconds", "date_time_with_ms", "name", "message")
TOKENS = (*_OURS, "process", "clock")


def _template(text: str) -> tuple[str, str]:
    """The template before and after its message; ValueError."""
    if "{" not in text:
        near = suggest(text, (DEFAULT, COMPACT))
        raise ValueError(
            f"unknown format '{text}'; "
            + (f"did you mean '{near}'?" if near else "default, compact, or a text with {message}")
        )
    _refuse_broken(text)
    for token in _TOKEN.findall(text):
        if token in _OF_NODES_ONLY:
            raise ValueError(
                f"{{{token}}} is not part of the lines of nodes; "
                "set RCUTILS_CONSOLE_OUTPUT_FORMAT for them"
            )
        if token not in TOKENS:
            known = ", ".join(f"{{{one}}}" for one in TOKENS)
            raise ValueError(f"unknown token {{{token}}} in a format; known: {known}")
    before, found, after = text.partition("{message}")
    if not found or "\n" in text:
        raise ValueError("a format is one line with {message}")
    return before, after.replace("{message}", "")


def _refuse_broken(text: str) -> None:
    """ValueError for a token without its end, and for `{time:.3f}`; other braces are text."""
    for name, rest, end in _BRACED.findall(text):
        token = f"{{{name}}}"
        if end and rest and (name in TOKENS or rest[0] in ":!"):
            raise ValueError(f"'{{{name}{rest}}}' in a format: tokens take no options; try {token}")
        if not end and name in TOKENS:
            raise ValueError(f"'{{{name}' in a format lacks its '}}'; write {token}")


def _parser(node_format: str) -> Callable[[bytes, int], OutputMessage | None]:
    """A function that splits a line in this format; None for other lines."""
    pattern, seen = rb"(?:%b)*" % _SGR, set()
    end = 0
    for found in _TOKEN.finditer(node_format):
        pattern += re.escape(_bytes(node_format[end : found.start()]))
        end = found.end()
        token = found[1]
        if token not in _PATTERNS:
            pattern += re.escape(_bytes(found[0]))
        elif token in seen:
            pattern += b"(?:%b)" % _PATTERNS[token]
        else:
            pattern += b"(?P<%b>%b)" % (token.encode(), _PATTERNS[token])
            seen.add(token)
    if node_format.endswith("{message}"):  # nearly always: a greedy search takes half the time
        pattern = pattern.replace(b"(?P<message>.*?)", b"(?P<message>.*)")
    else:
        pattern += re.escape(_bytes(node_format[end:])) + rb"(?:%b)*" % _SGR
    expression = re.compile(pattern, re.DOTALL)
    if not {"message", "severity"} <= seen:  # any line, or none, would fit
        return lambda line, now: None
    return functools.partial(_split, expression.fullmatch, frozenset(seen))


def _split(
    match: Callable[[bytes], re.Match[bytes] | None],
    tokens: frozenset[str],
    line: bytes,
    now: int,
) -> OutputMessage | None:
    found = match(line)
    if found is None:
        return None
    at_ns = now
    if "time" in tokens:
        second, _, rest = found["time"].partition(b".")
        at_ns = int(second) * NS + int(rest.ljust(9, b"0")[:9])
    elif "time_as_nanoseconds" in tokens:
        at_ns = int(found["time_as_nanoseconds"])
    name = found["name"] if "name" in tokens else b""
    text = found["message"].removesuffix(_RESET)
    return OutputMessage(found["severity"], at_ns, name, text)
