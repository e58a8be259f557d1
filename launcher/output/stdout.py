"""Writes our standard output, with prefixes and colours, without blocking."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections import deque
from collections.abc import Callable, Iterator, Mapping

from launcher.output.lines import for_pipe, for_terminal, with_prefix, without_colour
from launcher.posix.reactor import Reactor

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.spec import ProcessSpec
    from launcher.output.line_format import LineFormat

    Bytes = bytes | memoryview

HIGH_WATER = 1024 * 1024  # queued bytes above which children are not read
# The same for a terminal: what is queued is shown before the answer to a key, and after a `mute`.
TERMINAL_HIGH_WATER = 128 * 1024
COLLECT_S = 0.02  # for so long, lines may be collected and written together
# Errors of a full disk, which do not end the run. Any other error means that nobody reads.
FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
TOGETHER_BYTES = 16 * 1024  # a terminal takes half as much, and most lines are far shorter
LOW_PART = 4  # the children are read again when the queue is below 1/4 of that

# Colours that read on dark and on light terminals, neighbours far apart (256-colour palette).
_PALETTE = (39, 208, 77, 170, 220, 44, 203, 141, 113, 214, 75, 205, 150, 180, 117, 99)
_LEVELS = {"WARNING": b"\x1b[33m", "ERROR": b"\x1b[31m", "FATAL": b"\x1b[31m", "INFO": b"\x1b[2m"}
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


class StdoutWriter:
    """Writes blocks to a descriptor without blocking, and queues what cannot be written yet.

    `colour` is for our own lines, `plain` removes that of processes. `on_pressure(True)` is called
    when the queue is long, `on_pressure(False)` when it is short again; `on_closed()` once when
    the output has no reader any more (`| head`).
    """

    def __init__(self, reactor: Reactor, fd: int = 1, *, colour: bool, plain: bool = False) -> None:
        self._reactor = reactor
        self.fd, self._own = _non_blocking(fd)
        self.colour = colour
        self._plain = plain
        self.is_tty = os.isatty(fd)
        self._sound = for_terminal if self.is_tty else for_pipe
        self.closed = False
        self.dropped_bytes = 0
        self._waiting: deque[Bytes] = deque()
        self._waiting_bytes = 0
        self._pressed = False
        self._collected: list[bytes] | None = None
        self._collect_until_s = 0.0
        self._high_water = TERMINAL_HIGH_WATER if self.is_tty else HIGH_WATER
        self._partial_of: object = None
        self._partial = b""
        # The processes by their prefixes, each with its colour; and the form of lines, if it is not
        # that of ROS 2.
        self._sources: dict[bytes, tuple[ProcessSpec, bytes]] = {}
        self._format: LineFormat | None = None
        self._terminal = self.fd
        self._next_fd: int | None = None  # of the pipe to the console
        self.on_pressure: Callable[[bool], None] = lambda pressed: None
        self.on_closed: Callable[[], None] = lambda: None
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

    # ---- writing

    @contextlib.contextmanager
    def collecting(self) -> Iterator[None]:
        """Within, collect what is written for COLLECT_S, so that many lines are one write."""
        self._collected = []
        try:
            yield
        finally:
            collected, self._collected = self._collected, None
            if collected:
                self.write(b"".join(collected))

    def _collect(self, collected: list[bytes], block: bytes) -> None:
        now = self._reactor.now()
        if not collected:
            self._collect_until_s = now + COLLECT_S
        collected.append(block)
        if now > self._collect_until_s:
            self._collected = None
            self.write(b"".join(collected))
            self._collected = []

    def write(self, block: bytes) -> None:
        """Write bytes as they are."""
        if self._collected is not None:
            self._collect(self._collected, block)
            return
        if self.closed:
            return
        if self._waiting:
            self._waiting.append(block)
            self._waiting_bytes += len(block)
            self.push()
        else:
            rest = self._try(block)
            if not rest or self.closed:
                return
            self._reactor.remove(self.fd)  # it is still watched if `push` has emptied the queue
            self._reactor.add_writer(self.fd, self.flush)
            self._waiting.append(rest)
            self._waiting_bytes += len(rest)
        if self._waiting_bytes > self._high_water:
            self._press()

    def push(self) -> None:
        """Write of the queue what the output takes now; `flush` follows when it can take more.

        A terminal takes a few KB: it would have nothing to do while much more is being read.
        """
        while self._waiting:
            block = self._take_block()
            rest = self._try(block)
            self._waiting_bytes -= len(block) - len(rest)
            if rest:
                self._waiting.appendleft(rest)
                break

    def flush(self) -> None:
        """The same when the output can be written to, and what an empty queue allows."""
        self.push()
        if not self._waiting:
            self._reactor.remove(self.fd)
            self._divert_now()
        if self._waiting_bytes < self._high_water // LOW_PART and self._next_fd is None:
            self._release()

    def _take_block(self) -> Bytes:
        """The next block of the queue, together with those after it if they are short."""
        block = self._waiting.popleft()
        if len(block) >= TOGETHER_BYTES or not self._waiting:
            return block
        parts, size = [block], len(block)
        while self._waiting and size < TOGETHER_BYTES:
            parts.append(self._waiting.popleft())
            size += len(parts[-1])
        return b"".join(parts)

    def _press(self) -> None:
        if not self._pressed:
            self._pressed = True
            self.on_pressure(True)

    def _release(self) -> None:
        if self._pressed:
            self._pressed = False
            self.on_pressure(False)

    def _try(self, block: Bytes) -> Bytes:
        """Write without blocking; returns the rest."""
        try:
            written = os.write(self.fd, block)
            if written == len(block):
                return b""
            block = memoryview(block)[written:]  # a terminal takes 4 KB: do not copy the rest
            while block:
                block = block[os.write(self.fd, block) :]
        except BlockingIOError:
            pass
        except OSError as error:
            if error.errno in FULL:
                self._drop(block, error)
            else:
                self._close_output()  # EPIPE, EIO: it has no reader any more
            return b""
        return block

    def _drop(self, block: Bytes, error: OSError) -> None:
        if not self.dropped_bytes:
            from launcher.output.backlog import complain

            reason = f"cannot write the output: {error.strerror}"
            complain(f"{reason}; what does not fit is dropped")
        self.dropped_bytes += len(block)

    def _close_output(self) -> None:
        self.closed = True
        self._waiting.clear()
        self._waiting_bytes = 0
        self._reactor.remove(self.fd)
        self._release()
        self.on_closed()

    # ---- the console

    def divert(self, fd: int, on_diverted: Callable[[], None]) -> None:
        """Write to `fd`, which is non-blocking and owned by the caller, once the queue is empty.

        Earlier output goes to the terminal, but for an unfinished line that is short. The children
        are not read meanwhile, so that the queue gets empty even if they are faster than it.
        """
        self._next_fd, self._on_diverted = fd, on_diverted
        if self._waiting:
            self._press()
        self._divert_now()

    def _divert_now(self) -> None:
        if self._next_fd is None or self._waiting:
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

    @property
    def waiting_bytes(self) -> int:
        return self._waiting_bytes

    def take_waiting(self) -> bytes:
        """What could not be written yet; it is forgotten here."""
        waiting = b"".join(self._waiting)
        self._waiting.clear()
        self._waiting_bytes = 0
        self._partial_of = None
        self._reactor.remove(self.fd)
        return waiting

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


def _non_blocking(fd: int) -> tuple[int, bool]:
    """A non-blocking descriptor for the same output, and whether it is ours to close.

    O_NONBLOCK on a descriptor that we inherited would change the shell's as well, so terminals
    and pipes are opened again. Files do not block, and a second opening would lose the offset.
    """
    mode = os.fstat(fd).st_mode
    if stat.S_ISFIFO(mode) or stat.S_ISCHR(mode):
        with contextlib.suppress(OSError):
            flags = os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
            return os.open(f"/proc/self/fd/{fd}", flags), True
    return fd, False
