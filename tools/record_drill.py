"""Record the fleet drill: `make drill` writes docs/drill.svg.

Starts the whole system in a domain of its own in a real pseudo-terminal, types the commands of
docs/fleet.md, and draws what a terminal emulator shows then.
"""

from __future__ import annotations

import io
import os
import re
import sys
import tempfile
from pathlib import Path

from rich.console import Console
from rich.segment import Segment, Segments
from rich.style import Style
from rich.terminal_theme import DIMMED_MONOKAI

from launcher.domain_lease import leased_domain
from tests.support.drill import drill
from tests.support.screen_terminal import ScreenTerminal

COLUMNS, ROWS = 126, 30
TITLE = "python -m launcher system"
FOLDER = re.compile(r"(\S*/)?\.ros/log/\S+")  # contains time, host name and pid
FONT_FACE = re.compile(r"@font-face \{.*?\}\s*", re.DOTALL)
FORMAT_ID = "drill"


def main(target: str) -> int:
    """Write the picture to `target`."""
    with leased_domain() as domain_id, tempfile.TemporaryDirectory() as home:
        env = {
            **os.environ,
            "HOME": home,
            "ROS_DOMAIN_ID": str(domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "TERM": "xterm-256color",
        }
        for name in ("NO_COLOR", "FORCE_COLOR", "ROS_LOG_DIR", "ROS_HOME", "XDG_STATE_HOME"):
            env.pop(name, None)
        command = [sys.executable, "-m", "launcher", "system"]
        with ScreenTerminal(command, env=env, columns=COLUMNS, rows=ROWS) as terminal:
            drill(terminal)
            picture = draw(terminal)
            terminal.enter("quit")
            code = terminal.exit_code()
    Path(target).write_text(picture, encoding="utf-8")
    print(f"wrote {target}")
    return code


def draw(terminal: ScreenTerminal) -> str:
    """The screen as SVG without references to other files."""
    console = Console(record=True, width=COLUMNS, file=io.StringIO(), force_terminal=True)
    for row in terminal.cells():
        console.print(Segments([*_segments(row), Segment.line()]), end="")
    svg = console.export_svg(title=TITLE, theme=DIMMED_MONOKAI, unique_id=FORMAT_ID)
    return FONT_FACE.sub("", svg)


def _segments(row: list[tuple[str, str, bool]]) -> list[Segment]:
    """Segments of equal style; the name of the log folder is replaced."""
    runs: list[tuple[str, tuple[str, bool]]] = []
    for character, colour, bold in row:
        if runs and runs[-1][1] == (colour, bold):
            runs[-1] = (runs[-1][0] + character, (colour, bold))
        else:
            runs.append((character, (colour, bold)))
    return [
        Segment(FOLDER.sub("~/.ros/log/...", text), Style(color=_name(colour), bold=bold))
        for text, (colour, bold) in runs
    ]


def _name(colour: str) -> str | None:
    if colour == "default":
        return None
    if re.fullmatch("[0-9a-f]{6}", colour):
        return f"#{colour}"
    return {"brown": "yellow", "brightblack": "bright_black"}.get(colour, colour)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
