"""Says that Python compiles modules at every start: once, after the first start that does."""

from __future__ import annotations

import os

from launcher.base.program import program
from launcher.packages.byte_code import uncached
from launcher.posix.state_folder import state_folder
from launcher.run.part import Part

FILE = "notices"  # a line for each that was shown
MAX_BYTES = 64 * 1024  # of that file


class ByteCodeNotice(Part):
    """Once for each user and installation; not at all where that cannot be remembered."""

    def begin(self) -> None:
        found = uncached(self.run.env)
        path = os.path.join(state_folder(self.run.env), FILE)
        if found is not None and is_new(ascii(f"byte code {found.folders}"), path):
            self.run.log.log(
                "INFO", "launch", f"{found}: it takes twice as long; see `{program()} doctor`"
            )


def is_new(notice: str, path: str) -> bool:
    """Whether it is not in this file, to which it is added."""
    if not os.path.isabs(path):  # there is no home folder
        return False
    try:
        os.makedirs(os.path.dirname(path), 0o700, exist_ok=True)
        with open(path, "a+", encoding="ascii") as file:
            file.seek(0)
            shown = file.read(MAX_BYTES)
            if notice in shown.splitlines() or len(shown) == MAX_BYTES:
                return False
            file.write(f"{notice}\n")
    except (OSError, ValueError):
        return False
    return True
