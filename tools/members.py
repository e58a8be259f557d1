"""Print a warning while the table of the group's members is empty; `make test` ends with it."""

from __future__ import annotations

import sys
from itertools import dropwhile, takewhile
from pathlib import Path

PAGE = Path("group_gp1/README.md")
COLUMNS = ["name", "matriculation number", "e-mail"]


def warning(page: Path) -> str | None:
    """What to fill in, or None if at least one member is there."""
    lines = dropwhile(lambda line: not is_head(line), page.read_text(encoding="utf-8").splitlines())
    table = [_cells(line) for line in takewhile(lambda line: line.startswith("|"), lines)]
    if any(len(row) == len(COLUMNS) and all(row) for row in table[2:]):  # below head and rule
        return None
    return (
        f"warning: {page}: the table of group members is empty: fill in the {', '.join(COLUMNS)} "
        "of each member, and <maintainer> in package.xml"
    )


def is_head(line: str) -> bool:
    """Whether it is the head of the table of members."""
    return _cells(line) == COLUMNS


def _cells(row: str) -> list[str]:
    return [cell.strip() for cell in row.split("|")[1:-1]]


def main() -> None:
    found = warning(PAGE)
    if found is not None:
        print(found, file=sys.stderr)


if __name__ == "__main__":
    main()
