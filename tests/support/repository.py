"""Where the repository is, and the pages of its documentation."""

from __future__ import annotations

from pathlib import Path

from launcher.packages.distribution import installed

REPOSITORY = Path(__file__).resolve().parents[2]
DOCS = REPOSITORY / "docs"


def docs_page(name: str) -> str:
    """The text of a page of docs/; `name` is that of its file, without folders and `.md`."""
    (path,) = DOCS.rglob(f"{name}.md")
    return path.read_text(encoding="utf-8")


def pins() -> Path:
    """The list of `make run` for the ROS 2 in use."""
    of_distribution = REPOSITORY / f"requirements/run-{installed()}.txt"
    return of_distribution if of_distribution.is_file() else REPOSITORY / "requirements/run.txt"
