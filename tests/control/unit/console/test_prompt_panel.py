"""The panel of the prompt while the terminal changes its size."""

from __future__ import annotations

from types import SimpleNamespace

from prompt_toolkit.application import create_app_session
from prompt_toolkit.data_structures import Size
from prompt_toolkit.output import DummyOutput

from launcher.control.console.prompt import _panel


class GrowingOutput(DummyOutput):
    """A terminal that has another row whenever its size is read."""

    def __init__(self) -> None:
        self._rows = 1

    def get_size(self) -> Size:
        self._rows += 1
        return Size(rows=self._rows, columns=80)


def test_the_cursor_is_in_the_lines_that_are_drawn():
    output = GrowingOutput()
    panel = SimpleNamespace(
        lines=lambda columns, rows: [[("", "line")]] * rows,
        cursor=lambda lines: (0, len(lines) - 1),
        has_cursor=False,
    )
    with create_app_session(output=output):
        content = _panel(SimpleNamespace(panel=panel), output).content.create_content(80, 24)

    assert content.get_line(content.cursor_position.y)
