"""Writes output above the footer (prompt and status bar).

prompt_toolkit draws the footer at the cursor and updates it by differences. To write lines above
it, the footer is erased and drawn again below them, all in one write. The bytes of the footer are
kept until it changes, so that many lines cost no layout.
"""

from __future__ import annotations

import io
from collections.abc import Callable

from prompt_toolkit.application import Application
from prompt_toolkit.data_structures import Size
from prompt_toolkit.output import ColorDepth
from prompt_toolkit.output.vt100 import Vt100_Output

from launcher.base.text import drop_controls
from launcher.control.console.terminal import Terminal

SHORT_ROWS = 8  # rows; below it the status bar has one line instead of two

# Marks of the console's own lines, in the colour of the prompt.
SIGN, GUTTER = "> ", "| "
_COLOUR, _PLAIN = "\x1b[1;36m", "\x1b[0m"


class FooterOutput(Vt100_Output):
    """Output of prompt_toolkit; each drawing is passed to `sink` as one string."""

    def __init__(
        self, sink: Callable[[str], None], size: Callable[[], Size], *, colour: bool
    ) -> None:
        depth = None if colour else ColorDepth.DEPTH_1_BIT
        # No cursor position requests: the answers would mix with what is typed.
        super().__init__(io.StringIO(), size, default_color_depth=depth, enable_cpr=False)
        self._sink = sink

    def fileno(self) -> int:
        """prompt_toolkit needs it to suspend."""
        return 1

    def flush(self) -> None:
        if self._buffer:
            drawn = "".join(self._buffer)
            self._buffer = []
            self._sink(drawn)


class Display:
    """Shows lines above the footer; `application`, which draws it, must be set first."""

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
        """Write whole lines; `partial` becomes the unfinished line above the footer."""
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

    def show_text(self, text: str) -> None:
        """Show a text, which may hold output of processes or a pasted line."""
        if text:
            self.show(drop_controls(text.rstrip("\n")).encode(errors="replace") + b"\n")

    def echo(self, line: str) -> None:
        self.show_text(self._coloured(SIGN) + line)

    def answer(self, text: str) -> None:
        """Show an answer, with a mark before each line that sets it off from other output."""
        gutter = self._coloured(GUTTER)
        self.show_text("\n".join(gutter + line for line in text.rstrip("\n").split("\n")))

    def passed_on(self, lines: bytes) -> None:
        """Show whole lines of a verb that runs, each behind the mark of an answer."""
        gutter = self._coloured(GUTTER)
        texts = lines.decode(errors="replace").split("\n")[:-1]
        shown = "".join(f"{gutter}{text}\n" for text in texts)
        self.show(drop_controls(shown).encode(errors="replace"))

    def _coloured(self, mark: str) -> str:
        return f"{_COLOUR}{mark}{_PLAIN}" if self.colour else mark

    def footer_changed(self) -> None:
        """Draw the footer again with the next lines."""
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
