"""Record the console: `make drill` and `make picker` write pictures into docs/assets/.

Starts the whole system in a separate domain in a real pseudo-terminal, types what a scene types,
and draws what a terminal emulator shows then.
"""

from __future__ import annotations

import io
import os
import re
import signal
import sys
import tempfile
from collections.abc import Callable
from itertools import groupby
from pathlib import Path

from rich.console import Console
from rich.segment import Segment, Segments
from rich.style import Style
from rich.terminal_theme import DIMMED_MONOKAI

from launcher.posix.domain_lease import leased_domain
from tests.support.console_scenes import drill, picker, picker_log
from tests.support.screen_terminal import Cell, ScreenTerminal

ROWS = 30
# Name of the picture -> what is played, and in how many columns.
SCENES = {
    "drill": (drill, 120),
    "drill-80": (drill, 80),
    "picker": (picker, 120),
    "picker-log": (picker_log, 80),
}
TITLE = "python -m launcher system"
FOLDER = re.compile(r"(\S*/)?\.ros/log/\S+")  # contains time, host name and pid
FONT_FACE = re.compile(r"@font-face \{.*?\}\s*", re.DOTALL)
FORMAT_ID = "drill"


def main(folder: str, *names: str) -> int:
    """Write these pictures into `folder`."""
    return max(record(Path(folder) / f"{name}.svg", *SCENES[name]) for name in names)


def record(target: Path, scene: Callable[[ScreenTerminal], None], columns: int) -> int:
    """Play the scene and draw its end; the exit code of the run."""
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
        with ScreenTerminal(command, env=env, columns=columns, rows=ROWS) as terminal:
            scene(terminal)
            picture = draw(terminal, columns)
            terminal.kill(signal.SIGINT)
            code = terminal.exit_code()
    target.write_text(picture, encoding="utf-8")
    print(f"wrote {target}")
    return code


def draw(terminal: ScreenTerminal, columns: int) -> str:
    """The screen as SVG without references to other files."""
    console = Console(record=True, width=columns, file=io.StringIO(), force_terminal=True)
    for row in terminal.cells():
        console.print(Segments([*_segments(row), Segment.line()]), end="")
    svg = console.export_svg(title=TITLE, theme=DIMMED_MONOKAI, unique_id=FORMAT_ID)
    return FONT_FACE.sub("", svg)


def _segments(row: list[Cell]) -> list[Segment]:
    """Segments of equal style; the name of the log folder is replaced."""
    segments = []
    for (colour, bold, reverse), cells in groupby(row, lambda cell: cell[1:]):
        text = FOLDER.sub("~/.ros/log/...", "".join(character for character, *_ in cells))
        segments.append(Segment(text, Style(color=_name(colour), bold=bold, reverse=reverse)))
    return segments


def _name(colour: str) -> str | None:
    if colour == "default":
        return None
    if re.fullmatch("[0-9a-f]{6}", colour):
        return f"#{colour}"
    return {"brown": "yellow", "brightblack": "bright_black"}.get(colour, colour)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
