"""The display of a build."""

from __future__ import annotations

import io
import os

import pytest

from launcher.workspace.building.build_progress import Progress


class Screen(io.StringIO):
    """A terminal of a width."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, columns: int) -> None:
        super().__init__()
        monkeypatch.setenv("TERM", "xterm")
        size = os.terminal_size((columns, 24))
        monkeypatch.setattr(
            "launcher.workspace.building.status_line.os.get_terminal_size", lambda _: size
        )

    def isatty(self) -> bool:
        return True

    def fileno(self) -> int:
        return 1


def shown(stream: io.StringIO) -> str:
    """The line as it is on the screen."""
    return stream.getvalue().rpartition("\r")[2].removesuffix("\x1b[K")


def test_a_line_has_package_step_and_time(monkeypatch: pytest.MonkeyPatch):
    screen = Screen(monkeypatch, 100)
    progress = Progress(2, stream=screen)

    progress.start("my_msgs")
    progress.step("my_msgs", "cmake")
    assert shown(screen) == "[0/2] 0 s  my_msgs: configure"
    progress.step("my_msgs", "build")
    progress.line("my_msgs", "[3/40] Generating C code for ROS interfaces")
    assert shown(screen) == "[0/2] 0 s  my_msgs: generate 3/40"
    progress.line("my_msgs", "[12/40] Building C object a.o")
    assert shown(screen) == "[0/2] 0 s  my_msgs: compile 12/40"
    progress.end("my_msgs")
    assert "my_msgs: built (0.0 s)\n" in screen.getvalue()


def test_the_line_never_wraps(monkeypatch: pytest.MonkeyPatch):
    screen = Screen(monkeypatch, 50)
    progress = Progress(9, stream=screen)

    for number in range(9):
        progress.start(f"a_package_with_a_long_name_{number}")
        assert len(shown(screen)) < 50


@pytest.mark.parametrize("columns", [0, 30])
def test_a_narrow_terminal_has_plain_lines(monkeypatch: pytest.MonkeyPatch, columns: int):
    screen = Screen(monkeypatch, columns)
    progress = Progress(1, stream=screen)

    progress.start("one")
    progress.end("one", "failed")

    assert screen.getvalue() == "one: failed (0.0 s)\n"


def test_a_file_has_plain_lines():
    file = io.StringIO()
    progress = Progress(1, stream=file)

    progress.start("one")
    progress.step("one", "cmake")
    progress.end("one")

    assert file.getvalue() == "one: built (0.0 s)\n"


def test_control_characters_do_not_reach_the_terminal(monkeypatch: pytest.MonkeyPatch):
    screen = Screen(monkeypatch, 100)
    Progress(1, note="\x1b[31mred", stream=screen).start("one")

    assert "\x1b[31m" not in screen.getvalue()
