"""Print what a change in one room of `launcher/` can break, as words for pytest.

    python -m tools.wings bag

These are the tests of the room, of the rooms that may import it, and of the command line and
the documents, which read its tables; and every other test that names one of their modules or
verbs. Needs no package.
"""

from __future__ import annotations

import re
import sys

from launcher.base.verb_table import VERBS, module_of
from tests.docs.unit.test_architecture import CORE, WINGS
from tests.support.repository import REPOSITORY

USAGE_ERROR = 2


def users(room: str) -> set[str]:
    """The room and all that may import it, directly or not."""
    if room in CORE:
        return {*CORE[CORE.index(room) :], *WINGS}
    found: set[str] = set()
    new = {room}
    while new:
        found |= new
        new = {wing for wing, others in WINGS.items() if others & found} - found
    return found


def tests_of(room: str) -> list[str]:
    """Folders and files of `tests/`."""
    rooms = users(room)
    folders = [f"tests/{one}/" for one in sorted({*rooms, "cli", "docs"})]
    verbs = [verb for verb in VERBS if module_of(verb).split(".")[1] in rooms]
    names = [rf"launcher\.({'|'.join(rooms)})\b", *(f"[\"']{verb}[\"']" for verb in verbs)]
    named = re.compile("|".join(names))
    files = [
        file
        for path in sorted((REPOSITORY / "tests").rglob("test_*.py"))
        if not (file := str(path.relative_to(REPOSITORY))).startswith(tuple(folders))
        and named.search(path.read_text(encoding="utf-8"))
    ]
    return folders + files


def main() -> None:
    (room,) = sys.argv[1:]
    if room not in {*CORE, *WINGS}:
        print(f"error: no wing {room!r}; wings: {' '.join(sorted(WINGS))}", file=sys.stderr)
        print(f"hint: rooms of the core: {' '.join(CORE)}", file=sys.stderr)
        sys.exit(USAGE_ERROR)
    print(*tests_of(room))


if __name__ == "__main__":
    main()
