"""Write docs/reference/events.md: every event of the event log with its fields, from their types.

`python -m tools.event_reference`; a test compares the page with the types.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path

from launcher.base.model.event_entries import FIELD_TYPES, annotations_of
from launcher.base.model.record import Record
from launcher.base.model.run_event import TYPES
from launcher.base.model.run_events import Sample

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference" / "events.md"
HEAD = """\
# Events

What happens in a run is in its event log: in the file `events.jsonl` of its
[folder](running.md#files-of-a-run), a JSON object per line, and in the answers of
[`events`](control.md#verbs), which prints lines for people, and the objects with `--json`. This
page is generated: `python -m tools.event_reference`.

| field of every entry | type | unit | meaning |
|---|---|---|---|
| `wall_s` | number | s | when it happened, since 1970 |
| `monotonic_s` | number | s | the same on the monotonic clock of the launcher's machine |
| `event` | string | | its name, below |
| `process` | string | | the process that it is about; absent for events of the run |
| `host` | string | | the host of that process; absent for the launcher's machine |

Entries are in the order in which events reached the launcher; those about [other
hosts](hosts.md#a-lost-link) have the time when it happened there. What is not known is
null. Later versions may add events and fields: ignore what you do not know. The last line of a run
whose launcher was killed may be incomplete.
"""
EVENTS = """
| event | about | field | type | unit | meaning |
|---|---|---|---|---|---|
"""
SAMPLES = """
## Samples

Each of the `processes` of `resources`:

| field | type | unit | meaning |
|---|---|---|---|
"""


def page() -> str:
    """The whole page."""
    events = "\n".join(row for cls in TYPES.values() for row in event_rows(cls))
    _, texts = documented(Sample)
    samples = "\n".join(f"| {field_cells(Sample, *field)} |" for field in texts.items())
    return f"{HEAD}{EVENTS}{events}\n{SAMPLES}{samples}\n".replace("|  |", "| |")


def event_rows(cls: type[Record]) -> Iterator[str]:
    """The rows of an event: what it means, and each field."""
    sentence, texts = documented(cls)
    about = "process or run" if cls.about == "either" else cls.about
    yield f"| `{cls.event}` | {about} | | | | {sentence} |"
    for name, text in texts.items():
        yield f"| | | {field_cells(cls, name, text)} |"


def documented(cls: type[Record]) -> tuple[str, dict[str, str]]:
    """The sentence of its docstring, and the text of each field."""
    sentence, _, fields = inspect.cleandoc(cls.__doc__ or "").partition("\n\n")
    joined = re.sub(r"\n +", " ", fields)
    texts = dict(line.split(": ", 1) for line in joined.splitlines())
    assert [*texts] == [*cls._fields], f"the docstring of {cls.__name__} has other fields"
    return sentence.replace("\n", " "), texts


def field_cells(cls: type[Record], name: str, text: str) -> str:
    """Name, type, unit and meaning of a field."""
    kind, _, optional = annotations_of(cls)[name].partition(" | ")
    has_default = name not in cls._required
    type_name = f"{FIELD_TYPES[kind].json}{' or null' * bool(optional and not has_default)}"
    absence = "; absent if there is none" * has_default
    return " | ".join([f"`{name}`", type_name, FIELD_TYPES[kind].unit, f"{text}{absence}"])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
