"""What GitHub Actions shows of a command: annotations of files, and a summary of the step.

Also other services that run such workflows set these variables.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence

from launcher.base.option import option
from launcher.base.text import escape

_SUMMARY = "GITHUB_STEP_SUMMARY"
_MAX_CELL = 300
# What Markdown or GitHub could take for something else: links, names of users, numbers of issues.
_SPECIAL = re.compile(r"[\\`*_{}\[\]<>|~#@!&$:]")

# Of verbs that report to a workflow; at most one of them may be given.
GITHUB_OPTIONS = (
    option(
        "--github",
        "print annotations for GitHub Actions, and add to the summary of the step; default where "
        "GITHUB_ACTIONS is true",
    ),
    option("--no-github", "do not, there either"),
)
GITHUB_EXCLUSIVE = ("github", "no_github")


def is_on(env: Mapping[str, str]) -> bool:
    """Whether a workflow runs this command."""
    return env.get("GITHUB_ACTIONS") == "true"


def wants_github(*, github: bool, no_github: bool) -> bool:
    """Whether to report to a workflow, by these options."""
    return github or (is_on(os.environ) and not no_github)


def annotation(message: str, *, title: str, place: str = "") -> str:
    """The line that makes an annotation, at a place `FILE:LINE`."""
    path, _, line = place.rpartition(":")
    properties = {"file": _relative(path), "line": line} if path and line.isdigit() else {}
    shown = {**properties, "title": title}
    words = ",".join(f"{name}={_property(value)}" for name, value in shown.items())
    return f"::error {words}::{_data(message)}"


def _relative(path: str) -> str:
    """Relative to the root of the repository, where workflows run by default."""
    shown = os.path.relpath(path, os.environ.get("GITHUB_WORKSPACE") or os.curdir)
    return path if shown.startswith(os.pardir) else shown


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")


def add_summary(env: Mapping[str, str], lines: Iterable[str]) -> str | None:
    """Append Markdown to the summary of the step; why that is not possible.

    Nothing is done where the environment names no file for it.
    """
    path = env.get(_SUMMARY)
    if not path:
        return None
    try:
        with open(path, "a", encoding="utf-8", errors="backslashreplace") as file:
            file.write("\n".join([*lines, "", ""]))
    except OSError as error:
        return f"cannot write {_SUMMARY} {path}: {error.strerror}"
    return None


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """The lines of a table in Markdown, of plain texts."""
    lines = [" | ".join(map(plain, head)), " | ".join("---" for _ in head)]
    lines += [" | ".join(map(plain, row)) for row in rows]
    return [f"| {line} |" for line in lines]


def plain(text: str) -> str:
    """A text that Markdown shows as it is, in one line."""
    line = escape(" ".join(text.split()), keep="")
    shown = line if len(line) <= _MAX_CELL else f"{line[:_MAX_CELL]}..."
    return _SPECIAL.sub(lambda found: f"&#{ord(found[0])};", shown)
