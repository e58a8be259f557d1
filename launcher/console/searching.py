"""Searching: Ctrl-R in the lines that were typed before, as shells have it."""

from __future__ import annotations

from prompt_toolkit.application import get_app
from prompt_toolkit.buffer import Buffer
from prompt_toolkit.filters import is_searching
from prompt_toolkit.key_binding import KeyBindings, KeyPressEvent
from prompt_toolkit.search import SearchDirection, SearchState, accept_search, start_search
from prompt_toolkit.widgets import SearchToolbar

FOUND, NOT_FOUND = "search: ", "no line has: "
ALL = 1_000_000  # more lines than there are


def search_row(buffer: Buffer) -> SearchToolbar:
    """The row below the prompt in which a person types what to search for."""
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
    """Ctrl-R, and what ends it: Enter runs the line, other keys leave it to be changed."""
    keys = KeyBindings()

    @keys.add("c-r", filter=~is_searching)
    def _(event: KeyPressEvent) -> None:
        """From the newest line: one that was fetched and emptied would hide all after it."""
        if not buffer.text:
            buffer.history_forward(ALL)
        start_search(direction=SearchDirection.BACKWARD)

    @keys.add("enter", filter=is_searching)
    def _(event: KeyPressEvent) -> None:
        is_found = _is_found(buffer, get_app().current_buffer.text)
        accept_search()
        buffer.cursor_position = len(buffer.text)
        if is_found:
            buffer.validate_and_handle()

    @keys.add("escape", filter=is_searching, eager=True)
    @keys.add("left", filter=is_searching)
    @keys.add("right", filter=is_searching)
    @keys.add("end", filter=is_searching)
    @keys.add("c-e", filter=is_searching)
    @keys.add("tab", filter=is_searching)
    def _(event: KeyPressEvent) -> None:
        accept_search()
        buffer.cursor_position = len(buffer.text)

    @keys.add("home", filter=is_searching)
    @keys.add("c-a", filter=is_searching)
    def _(event: KeyPressEvent) -> None:
        accept_search()
        buffer.cursor_position = 0

    return keys
