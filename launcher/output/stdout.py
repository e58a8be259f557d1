"""Writes our standard output, with prefixes and colours, without blocking."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Mapping

from launcher.output.lines import for_pipe, for_terminal, with_prefix, without_colour
from launcher.output.output_queue import OutputQueue
from launcher.posix.reactor import Reactor

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.spec import ProcessSpec
    from launcher.output.line_format import LineFormat

# Colours that read on dark and on light terminals, neighbours far apart (256-colour palette).
_PALETTE = (39, 208, 77, 170, 220, 44, 203, 141, 113, 214, 75, 205, 150, 180, 117, 99)
_RED = b"\x1b[31m"
_LEVELS = {"WARNING": b"\x1b[33m", "ERROR": _RED, "CRITICAL": _RED, "INFO": b"\x1b[2m"}
_RESET = b"\x1b[0m"
_OVERWRITE = b"\r\x1b[K"  # for progress bars, whose lines begin or end with \r
PINNED_BYTES = 1000  # longest unfinished line that is repeated below lines of other processes


def wants_colour(fd: int, env: Mapping[str, str]) -> bool:
    """Whether output to `fd` is coloured: NO_COLOR, then FORCE_COLOR, then whether it is a tty."""
    if env.get("NO_COLOR"):
        return False
    if env.get("FORCE_COLOR"):
        return env["FORCE_COLOR"] != "0"
    return os.isatty(fd) and env.get("TERM") != "dumb"


def passes_colour(fd: int, env: Mapping[str, str]) -> bool:
    """Whether the colours of processes reach the output.

    As for our own, but RCUTILS_COLORIZED_OUTPUT=1 keeps them in a pipe, too (CONFORMANCE 1.34).
    """
    if env.get("NO_COLOR") or env.get("FORCE_COLOR"):
        return wants_colour(fd, env)
    return env.get("RCUTILS_COLORIZED_OUTPUT") == "1" or wants_colour(fd, env)


class StdoutWriter(OutputQueue):
    """Lines of processes and our own, to a terminal, a pipe or the console.

    `colour` is for our own lines, `plain` removes that of processes.
    """

    def __init__(self, reactor: Reactor, fd: int = 1, *, colour: bool, plain: bool = False) -> None:
        super().__init__(reactor, fd)
        self.colour = colour
        self._plain = plain
        self._sound = for_terminal if self.is_tty else for_pipe
        self._partial_of: object = None
        self._partial = b""
        # The processes by their prefixes, each with its colour; and the form of lines, if it is not
        # that of ROS 2.
        self._sources: dict[bytes, tuple[ProcessSpec, bytes]] = {}
        self._format: LineFormat | None = None
        self._terminal = self.fd
        self.taken_bytes: Callable[[], int] = lambda: 0  # by the terminal, from the console

    @property
    def columns(self) -> int | None:
        """Columns of the terminal; None if there is none."""
        if not self.is_tty:
            return None
        with contextlib.suppress(OSError):
            return os.get_terminal_size(self._terminal).columns or None
        return None

    # ---- lines

    def prefix(self, spec: ProcessSpec, index: int) -> bytes:
        """`[name] `, in the colour of the process with this number where there are colours."""
        text, colour = f"[{spec.name}]".encode(), b""
        if self.colour:
            colour = b"\x1b[38;5;%dm" % _PALETTE[index % len(_PALETTE)]
            text = colour + text + _RESET
        prefix = text + b" "
        self._sources[prefix] = spec, colour
        return prefix

    @property
    def format(self) -> str:
        """`default`, `compact` or a template."""
        return "default" if self._format is None else self._format.name

    @format.setter
    def format(self, name: str) -> None:
        if name == "default":
            self._format = None
            return
        from launcher.output.line_format import LineFormat

        self._format = LineFormat(name, self._sources, colour=self.colour)

    def write_lines(self, source: object, prefix: bytes, lines: bytes, shown: int = 0) -> None:
        """Write whole lines of a process. `shown` is as in `LineBuffer`."""
        if self._format is not None:
            self._write_formatted(self._format, source, prefix, lines, shown)
            return
        if not shown or self._partial_of is not source:
            self._write_around(with_prefix(prefix, self._clean(lines)), source)
            return
        if self._goes_back(lines, shown):
            block = _OVERWRITE + with_prefix(prefix, self._clean(lines))
        else:
            block = with_prefix(prefix, self._clean(lines[shown:]))[len(prefix) :]
        self._partial_of = None
        self.write(block)

    def _write_formatted(
        self, form: LineFormat, source: object, prefix: bytes, lines: bytes, shown: int
    ) -> None:
        if not shown or self._partial_of is not source:
            self._write_around(form.lines(prefix, source, self._clean(lines)), source)
            return
        if self._goes_back(lines, shown):
            block = _OVERWRITE + form.lines(prefix, source, self._clean(lines))
        else:
            end, newline, rest = self._clean(lines[shown:]).partition(b"\n")
            block = end + newline + (form.lines(prefix, source, rest) if rest else b"")
        self._partial_of = None
        self.write(block)

    def _goes_back(self, lines: bytes, shown: int) -> bool:
        """Whether the rest of a line is written over what is shown of it: by a terminal only."""
        return self.is_tty and b"\r" in lines[shown - 1 : lines.index(b"\n")].rstrip(b"\r")

    def write_partial(self, source: object, prefix: bytes, partial: bytes, shown: int) -> int:
        """Write an unfinished line; the number of its bytes that are shown now."""
        if self.is_tty and not partial.isascii():
            from launcher.output.escapes import whole_characters

            partial = whole_characters(partial)
            if len(partial) <= shown:
                return shown
        if self._format is not None and (self._partial_of is not source or b"\r" in partial):
            prefix = self._format.head(prefix, source)
        is_bar = b"\r" in partial[max(0, shown - 1) :]
        if is_bar and not self.is_tty:
            return shown
        if self._partial_of is not source:
            newline = b"\n" if self._partial_of is not None else b""
            self._partial = prefix + self._clean(partial + b"\n")[:-1]
            self.write(newline + self._partial)
        elif is_bar:  # write over what is there
            self._partial = prefix + self._clean(partial[shown:] + b"\n")[:-1]
            self.write(_OVERWRITE + self._partial)
        else:
            more = self._clean(partial[shown:] + b"\n")[:-1]
            self._partial += more
            self.write(more)
        self._partial_of = source
        return len(partial)

    def end_partial(self, source: object) -> None:
        """End the unfinished line of `source` if it is shown."""
        if self._partial_of is source:
            self._partial_of = None
            self.write(b"\n")

    def _write_around(self, block: bytes, source: object = None) -> None:
        """Write whole lines while another source has an unfinished one.

        The console repeats that line below them, so that a question stays visible until it is
        answered. On a terminal, where it may have been wrapped, it ends here.
        """
        if self._partial_of is None:
            self.write(block)
            return
        if (
            self.has_console
            and self._partial_of is not source
            and len(self._partial) <= PINNED_BYTES
        ):
            self.write(_OVERWRITE + block + self._partial)
            return
        self._partial_of = None
        self.write(b"\n" + block)

    def _clean(self, lines: bytes) -> bytes:
        text = self._sound(lines)
        if not self._plain or text is lines:
            return text
        return without_colour(text)

    def log(self, level: str, logger: str, text: str) -> None:
        """Write a line of our own: `[INFO] [launch]: text`, as ROS 2 does."""
        if self._format is not None:
            line = self._clean(text.encode(errors="surrogateescape") + b"\n")
            self._write_around(self._format.own(level, logger, line))
            return
        head = f"[{level}] [{logger}]:".encode()
        if self.colour:
            head = _LEVELS.get(level, b"") + head + _RESET
        line = self._clean(text.encode(errors="surrogateescape") + b"\n")
        self._write_around(head + b" " + line)

    def log_line(self, line: str) -> None:
        """Write a line of our own that is formatted already."""
        if self._format is not None:
            self._format.interrupt()
        self._write_around(self._clean(line.encode(errors="surrogateescape") + b"\n"))

    # ---- the console

    def divert(self, fd: int, on_diverted: Callable[[], None]) -> None:
        """Write to `fd`, which is non-blocking and owned by the caller, once the queue is empty.

        Earlier output goes to the terminal, but for an unfinished line that is short. The children
        are not read meanwhile, so that the queue gets empty even if they are faster than it.
        """
        self._next_fd, self._on_diverted = fd, on_diverted
        if self._waiting:
            self._press()
        else:
            self._has_emptied()

    def _has_emptied(self) -> None:
        """Write to the console from now on, if there is one."""
        if self._next_fd is None:
            return
        source, partial = self._partial_of, self._partial
        if source is not None:
            self._partial_of = None
            self.write(_OVERWRITE if len(partial) < (self.columns or 0) else b"\n")
            if self._waiting:
                return
        self._reactor.remove(self.fd)
        self.fd, self._next_fd = self._next_fd, None
        self._on_diverted()
        if source is not None and len(partial) <= PINNED_BYTES:
            self._partial_of = source  # a question moves above the prompt
            self.write(partial)

    def come_back(self, left: bytes) -> None:
        """Write to the terminal again: first `left`, which the console has not read."""
        self._next_fd = None
        if self.fd == self._terminal:
            if not self._waiting:
                self._release()
            return
        self._reactor.remove(self.fd)
        self.fd = self._terminal
        self._partial_of = None
        if left:
            self._waiting.appendleft(left)
            self._waiting_bytes += len(left)
        if self._waiting:
            self._reactor.add_writer(self.fd, self.flush)

    # ---- the end

    @property
    def has_console(self) -> bool:
        """Whether the output goes to the console."""
        return self.fd != self._terminal

    def take_waiting(self) -> bytes:
        self._partial_of = None
        return super().take_waiting()

    def settle(self, *, is_interrupted: bool) -> int:
        """Wait for a slow reader before the last lines; the number of lines that were dropped."""
        if self.closed or not (self._waiting or self.has_console):
            return 0
        from launcher.output.backlog import Backlog

        return Backlog(self._reactor, self).settle(is_interrupted=is_interrupted)

    def finish(self) -> int:
        """Write the queue and close the output; the number of lines that were not taken."""
        lost_lines = 0
        if self._waiting:
            from launcher.output.backlog import Backlog

            lost_lines = Backlog(self._reactor, self).finish()
        self._reactor.remove(self.fd)
        if self._own:
            os.close(self._terminal)
            self._own = False
        return lost_lines
