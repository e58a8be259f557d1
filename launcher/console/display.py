"""Display: lines that scroll, and below them the footer with the prompt.

prompt_toolkit draws the footer where the cursor is and changes it by differences. Lines go above
it by erasing it, writing them, and drawing it anew, all in one write, so that nothing is ever
mixed. The footer drawn anew is kept as bytes until it changes: a flood of lines costs no layout.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable

from prompt_toolkit.application import Application
from prompt_toolkit.data_structures import Size
from prompt_toolkit.output import ColorDepth
from prompt_toolkit.output.vt100 import Vt100_Output

from launcher.console.terminal import Terminal

# Answers hold what processes wrote (`logs`), and a person may paste anything.
_STEERING = re.compile("\x1b(?!\\[[0-9;:]*m)|[\x00-\x08\x0b-\x1a\x1c-\x1f\x7f-\x9f]")

LITTLE_HEIGHT = 8  # rows; below it there is one line of status instead of two

# What tells the console's own lines from those of processes, in the prompt's colour.
SIGN, GUTTER = "> ", "| "
_OURS, _PLAIN = "\x1b[1;36m", "\x1b[0m"


class FooterOutput(Vt100_Output):
    """What prompt_toolkit draws on; each drawing goes to `sink` as one string."""

    def __init__(
        self, sink: Callable[[str], None], size: Callable[[], Size], *, colour: bool
    ) -> None:
        depth = None if colour else ColorDepth.DEPTH_1_BIT
        # No questions about the cursor: the answer would come in between what a person types.
        super().__init__(io.StringIO(), size, default_color_depth=depth, enable_cpr=False)
        self._sink = sink

    def fileno(self) -> int:
        """The terminal's, which prompt_toolkit asks for when it is to be suspended."""
        return 1

    def flush(self) -> None:
        """Hand over what was drawn."""
        if self._buffer:
            drawn = "".join(self._buffer)
            self._buffer = []
            self._sink(drawn)


class Display:
    """Shows lines above the footer that `application` draws; set it before the first line."""

    application: Application[None]

    def __init__(self, terminal: Terminal, *, colour: bool) -> None:
        self._terminal = terminal
        self.colour = colour
        self.output = FooterOutput(self._drawn, terminal.size, colour=colour)
        self.has_footer = False
        self.partial = b""
        self._footer: bytes | None = None
        self._caught: list[str] | None = None

    def show(self, lines: bytes, partial: bytes | None = None) -> None:
        """Write whole lines above the footer; `partial` is the new unfinished line above it."""
        if partial is not None and partial != self.partial:
            self.partial = partial
            self.footer_changed()
            self.application.invalidate()
        if not lines:
            return
        if self.has_footer:
            self._terminal.write(self._erasing() + lines + self._drawing())
        else:
            self._terminal.write(lines)

    def say(self, text: str) -> None:
        """The same for a text, with or without a newline at its end; of control only colour."""
        if text:
            self.show(_STEERING.sub("", text.rstrip("\n")).encode(errors="replace") + b"\n")

    def echo(self, line: str) -> None:
        """A line that a person entered."""
        self.say(self._ours(SIGN) + line)

    def answer(self, text: str) -> None:
        """What a verb said, each line behind a mark, so that no process seems to have said it."""
        gutter = self._ours(GUTTER)
        self.say("\n".join(gutter + line for line in text.rstrip("\n").split("\n")))

    def _ours(self, mark: str) -> str:
        return f"{_OURS}{mark}{_PLAIN}" if self.colour else mark

    def footer_changed(self) -> None:
        """What was kept of the footer is not what it would look like now."""
        self._footer = None

    def _drawn(self, text: str) -> None:
        if self._caught is not None:
            self._caught.append(text)
            return
        self.footer_changed()
        self._terminal.write(text.encode(errors="replace"))

    def _erasing(self) -> bytes:
        screen = self.application.renderer.last_rendered_screen
        if screen is None:
            return b""
        row = screen.get_cursor_position(self.application.layout.current_window).y
        up = b"\x1b[%dA" % row if row else b""
        return b"\r" + up + b"\x1b[J"

    def _drawing(self) -> bytes:
        if self._footer is None:
            self._caught = []
            self.application.renderer.reset()
            self.application._redraw()
            self._footer, self._caught = "".join(self._caught).encode(errors="replace"), None
        return self._footer
