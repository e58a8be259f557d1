"""The footer of the console: prompt, search, completions and status bar, by prompt_toolkit."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from prompt_toolkit.application import Application, get_app
from prompt_toolkit.buffer import Buffer
from prompt_toolkit.completion import Completer
from prompt_toolkit.data_structures import Point
from prompt_toolkit.filters import Condition, has_completions, is_searching
from prompt_toolkit.formatted_text import ANSI, AnyFormattedText, StyleAndTextTuples
from prompt_toolkit.history import History, InMemoryHistory
from prompt_toolkit.input.posix_utils import PosixStdinReader
from prompt_toolkit.input.vt100 import Vt100Input
from prompt_toolkit.key_binding import KeyBindings, KeyPress, KeyPressEvent, merge_key_bindings
from prompt_toolkit.keys import Keys
from prompt_toolkit.layout import ConditionalContainer, HSplit, Layout, Window
from prompt_toolkit.layout.controls import BufferControl, FormattedTextControl
from prompt_toolkit.layout.processors import BeforeInput
from prompt_toolkit.search import SearchDirection, SearchState, accept_search, start_search
from prompt_toolkit.styles import Style
from prompt_toolkit.utils import get_cwidth
from prompt_toolkit.widgets import SearchToolbar

from launcher.control.console.bar import Line
from launcher.control.console.display import SHORT_ROWS, SIGN, FooterOutput

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.control.console.console_session import ConsoleSession


MAX_LINES = 1000
MAX_CANDIDATE_ROWS = 4
FOUND, NOT_FOUND = "search: ", "no line has: "
ALL = 1_000_000  # more than the history has lines
# NUL would set a mark, and all keys after it would edit the region.
_IGNORED = (Keys.ControlAt,)

COLOURS = Style.from_dict(
    {
        "prompt": "bold ansicyan",
        "bar": "",
        "bar.running": "ansigreen",
        "bar.waiting": "ansiyellow",
        "bar.trouble": "bold ansired",
        "bar.quiet": "",  # no grey is legible on every background
        "chosen": "reverse",
    }
)
PLAIN = Style.from_dict({"prompt": "bold", "bar.trouble": "bold", "chosen": "reverse"})


def make_application(
    host: ConsoleSession,
    *,
    output: FooterOutput,
    completer: Completer,
    history: History,
    colour: bool,
) -> Application[None]:
    """An application that erases itself when it exits."""

    def accept(buffer: Buffer) -> bool:
        host.entered(buffer.text)
        return False  # the line is empty again

    buffer = Buffer(completer=completer, history=history, multiline=False, accept_handler=accept)
    panel = _panel(host, output)
    layout = Layout(_rows(buffer, host, output, panel))

    def move_focus(application: Application[None]) -> None:
        if host.panel.is_open != layout.has_focus(panel):
            layout.focus(panel if host.panel.is_open else buffer)

    return Application(
        layout=layout,
        before_render=move_focus,
        key_bindings=merge_key_bindings([_keys(host, buffer), search_keys(buffer)]),
        style=COLOURS if colour else PLAIN,
        input=Keyboard(lambda: host.panel.is_open),
        output=output,
        erase_when_done=True,
        terminal_size_polling_interval=None,
    )


def _rows(buffer: Buffer, host: ConsoleSession, output: FooterOutput, panel: Window) -> HSplit:
    search = search_row(buffer)
    sign = BeforeInput(SIGN, style="class:prompt")
    above = Condition(lambda: bool(host.above()))
    few = Condition(lambda: output.get_size().rows < SHORT_ROWS)
    picking = Condition(lambda: host.panel.is_open)

    def status() -> StyleAndTextTuples:
        return _below_each_other(host.status(output.get_size().columns, few=few()))

    def helping() -> StyleAndTextTuples:
        size = output.get_size()
        taken = MAX_CANDIDATE_ROWS + 1 if buffer.complete_state else 0
        return _below_each_other(host.help.lines(size.columns, size.rows - taken))

    prompt = Window(
        BufferControl(
            buffer,
            input_processors=[sign],
            search_buffer_control=search.control,
            preview_search=True,
        ),
        height=1,
        # By default a window that has scrolled, as in a narrow terminal, comes back no farther
        # than to the cursor.
        get_horizontal_scroll=lambda window: 0,
    )

    return HSplit(
        [
            ConditionalContainer(_text(lambda: ANSI(host.above())), above),
            ConditionalContainer(_text(helping), Condition(lambda: host.help.is_open) & ~picking),
            ConditionalContainer(panel, picking),
            ConditionalContainer(prompt, ~picking),
            search,
            ConditionalContainer(
                _text(lambda: _candidates(buffer, output.get_size().columns)),
                has_completions & ~few & ~picking,
            ),
            _text(status),
        ]
    )


def _below_each_other(lines: Sequence[Line]) -> StyleAndTextTuples:
    pieces: StyleAndTextTuples = []
    for number, line in enumerate(lines):
        pieces += [("", "\n"), *line] if number else line
    return pieces


def _panel(host: ConsoleSession, output: FooterOutput) -> Window:
    shown: list[Line] = []

    def text() -> StyleAndTextTuples:
        size = output.get_size()
        shown[:] = host.panel.lines(size.columns, size.rows)
        return _below_each_other(shown)

    def cursor() -> Point:
        # In the lines that are drawn: the terminal may have another size by now.
        column, row = host.panel.cursor(shown)
        return Point(column, row)

    return Window(
        FormattedTextControl(text, focusable=True, get_cursor_position=cursor),
        dont_extend_height=True,
        wrap_lines=False,
        always_hide_cursor=~Condition(lambda: host.panel.has_cursor),
    )


def _text(text: Callable[[], AnyFormattedText]) -> Window:
    return Window(
        FormattedTextControl(text),
        dont_extend_height=True,
        wrap_lines=False,
        always_hide_cursor=True,
    )


def _candidates(buffer: Buffer, columns: int) -> StyleAndTextTuples:
    """Completions in columns; the chosen one is marked and explained below."""
    state = buffer.complete_state
    if state is None:
        return []
    texts = [completion.display_text for completion in state.completions]
    cell = max(map(get_cwidth, texts)) + 2
    per_row = max(1, columns // cell)
    chosen = state.complete_index
    first_row = (chosen or 0) // per_row // MAX_CANDIDATE_ROWS * MAX_CANDIDATE_ROWS
    pieces: StyleAndTextTuples = []
    for index, text in enumerate(texts):
        row, column = divmod(index, per_row)
        if not first_row <= row < first_row + MAX_CANDIDATE_ROWS:
            continue
        if column == 0 and row > first_row:
            pieces.append(("", "\n"))
        pieces.append(("class:chosen" if index == chosen else "", text))
        pieces.append(("", " " * (cell - get_cwidth(text))))
    if state.current_completion is not None and state.current_completion.display_meta_text:
        pieces += [("", "\n"), ("class:bar.quiet", state.current_completion.display_meta_text)]
    return pieces


def _keys(host: ConsoleSession, buffer: Buffer) -> KeyBindings:
    keys = KeyBindings()

    def insert(text: str) -> None:
        buffer.insert_text("".join(filter(str.isprintable, text.replace("\t", " "))))

    picking = Condition(lambda: host.panel.is_open)
    watching = Condition(host.is_watching) | picking

    @keys.add("c-c", eager=True)
    def _(event: KeyPressEvent) -> None:
        host.signalled(signal.SIGINT)

    @keys.add("c-\\", eager=True)
    def _(event: KeyPressEvent) -> None:
        host.signalled(signal.SIGQUIT)

    @keys.add("c-z", eager=True)
    def _(event: KeyPressEvent) -> None:
        host.suspended()

    @keys.add(Keys.Any, filter=watching, eager=True)
    def _(event: KeyPressEvent) -> None:
        press = event.key_sequence[0]
        host.any_key(press.key.value if isinstance(press.key, Keys) else press.key, press.data)

    helping = Condition(lambda: host.help.is_open) & ~watching & ~is_searching

    @keys.add("escape", filter=helping, eager=True)
    def _(event: KeyPressEvent) -> None:
        host.help.close()

    @keys.add("pageup", filter=helping)
    @keys.add("pagedown", filter=helping)
    def _(event: KeyPressEvent) -> None:
        host.help.press(event.key_sequence[0].key)

    @keys.add("f2", filter=~is_searching)
    def _(event: KeyPressEvent) -> None:
        host.panel.open()

    @keys.add("f3", filter=~is_searching & Condition(lambda: not buffer.text))
    def _(event: KeyPressEvent) -> None:
        insert("snapshot")
        buffer.validate_and_handle()

    @keys.add(Keys.BracketedPaste)
    def _(event: KeyPressEvent) -> None:
        """Each line is entered as if it were typed; the last one can be edited."""
        *whole, rest = event.data.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        for line in whole:
            insert(line)
            buffer.validate_and_handle()
        insert(rest)

    @keys.add("c-d", filter=Condition(lambda: not buffer.text))
    def _(event: KeyPressEvent) -> None:
        host.left()

    @keys.add("c-l", filter=picking, eager=True)
    @keys.add("c-l")
    def _(event: KeyPressEvent) -> None:
        event.app.renderer.clear()

    return keys


class Keyboard(Vt100Input):
    """The terminal on standard input; bytes that cannot be decoded become U+FFFD.

    Where `single_keys` is true, letters are commands. A key that prompt_toolkit does not
    recognize arrives as Esc and letters in one read, and is ignored then.
    """

    def __init__(self, single_keys: Callable[[], bool]) -> None:
        super().__init__(sys.stdin)
        self._single_keys = single_keys
        self.stdin_reader = PosixStdinReader(
            self.fileno(), errors="replace", encoding=sys.stdin.encoding
        )

    def read_keys(self) -> list[KeyPress]:
        read = [press for press in super().read_keys() if press.key not in _IGNORED]
        if len(read) > 1 and self._single_keys():
            return list(_known(read))
        return read


def _known(presses: Sequence[KeyPress]) -> Iterator[KeyPress]:
    """Without Esc and the letters behind it, up to a key that is known again."""
    is_known = True
    for press in presses:
        if isinstance(press.key, Keys):
            is_known = press.key != Keys.Escape
        if is_known:
            yield press


def search_row(buffer: Buffer) -> SearchToolbar:
    """The row below the prompt for the text to search for."""
    searched = Buffer()

    def label() -> str:
        return FOUND if _is_found(buffer, searched.text) else NOT_FOUND

    return SearchToolbar(
        searched, backward_search_prompt=label, forward_search_prompt=label, ignore_case=True
    )


def _is_found(buffer: Buffer, text: str) -> bool:
    state = SearchState(text, direction=SearchDirection.BACKWARD, ignore_case=True)
    return text.lower() in buffer.document_for_search(state).text.lower()


def search_keys(buffer: Buffer) -> KeyBindings:
    """Ctrl-R starts a search; Enter runs the line that was found, other keys edit it."""
    keys = KeyBindings()

    @keys.add("c-r", filter=~is_searching)
    def _(event: KeyPressEvent) -> None:
        """Search from the newest line, even if an older one was fetched and deleted."""
        if not buffer.text:
            buffer.history_forward(ALL)
        start_search(direction=SearchDirection.BACKWARD)

    def accept(event: KeyPressEvent) -> None:
        accept_search()
        is_home = event.key_sequence[0].key in (Keys.Home, Keys.ControlA)
        buffer.cursor_position = 0 if is_home else len(buffer.text)

    @keys.add("enter", filter=is_searching)
    def _(event: KeyPressEvent) -> None:
        is_found = _is_found(buffer, get_app().current_buffer.text)
        accept(event)
        if is_found:
            buffer.validate_and_handle()

    for key in ("escape", "left", "right", "end", "c-e", "tab", "home", "c-a"):
        keys.add(key, filter=is_searching, eager=key == "escape")(accept)
    return keys


def open_history(path: Path) -> History:
    """The history in this file, shortened if need be; in memory if it cannot be written."""
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with open(os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600), "r+") as file:
            lines = list(filter(None, file.read().split("\n")))
            if len(lines) > 2 * MAX_LINES:
                file.seek(0)
                file.truncate()
                file.writelines(f"{line}\n" for line in lines[-MAX_LINES:])
    except (OSError, UnicodeDecodeError):
        return InMemoryHistory()
    return _LinesInFile(path, lines[-MAX_LINES:])


class _LinesInFile(History):
    """One entry per line; several consoles append to the same file."""

    def __init__(self, path: Path, lines: list[str]) -> None:
        super().__init__()
        self._path = path
        self._lines = lines

    def load_history_strings(self) -> Iterable[str]:
        """Newest first."""
        return reversed(self._lines)

    def store_string(self, string: str) -> None:
        """Append a line; a full disk is ignored."""
        with contextlib.suppress(OSError), self._path.open("a", encoding="utf-8") as file:
            file.write(string + "\n")
