"""The name of the program in usages and hints; the browser."""

from __future__ import annotations

import os
import sys

SCRIPT = "launcher"


def program() -> str:
    """`launcher` if that command was started, `python -m launcher` otherwise."""
    return SCRIPT if os.path.basename(sys.argv[0]) == SCRIPT else f"python -m {SCRIPT}"


def without_program(words: list[str]) -> list[str]:
    """The words of a command line without the name of the program in front, however spelled."""
    if words and os.path.basename(words[0]) == SCRIPT:
        return words[1:]
    is_python = words[1:3] == ["-m", SCRIPT] and os.path.basename(words[0]).startswith("python")
    return words[3:] if is_python else words


def browse(link: str) -> None:
    """Open a link in the browser, if there is a desktop."""
    if any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")):
        import webbrowser

        webbrowser.open(link)
