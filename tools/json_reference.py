"""Write docs/reference/json.md: the keys of what each verb prints with `--json`.

`python -m tools.json_reference`; a test compares the page with the table, and others compare
answers of verbs with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tools.json_forms import FORMS, Form

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference" / "json.md"
HEAD = """\
# JSON for programs

What verbs print with `--json`. This page is generated: `python -m tools.json_reference`.

A verb prints one object; verbs that go on, marked *lines*, print one on each line (JSON Lines).
Notes and errors go to standard error. Exit codes are as without `--json`.

## Versions

Every object has `version`, now 1 everywhere. As long as it is the same, no key of that verb is
removed, renamed, or changes its meaning, type or unit; otherwise it is raised, and
[CHANGELOG.md](../../CHANGELOG.md) says so. Keys may be added at any time, and new values of
`state`, `event`, `kind` and the like: ignore what you do not know.

## Names

Keys are in snake_case, and one thing has one key in all verbs: `pid`, `host`, `domain_id`,
`uss_bytes`; `name` in a list of such things, `process`, `node` or `topic` elsewhere. A unit ends a
key: `_s`, `_ns`, `_hz`, `_bytes`, `_percent` (of one core); `wall_s` counts from 1970. Only `plan`
keeps the names of launch files, and `time`, `since_cause` and `timeout` in seconds. `returncode` is
an exit code, or minus the number of the signal that ended the process.

What is not known is null. Fields of messages, parameters and variables keep their names; nan and
inf of messages are the texts `nan`, `inf`, `-inf`.

[Control socket](control.md#versions), [event log](events.md), [probe](probe.md) and files
of other standards (JUnit, SARIF, JSON Schema) have their own rules.

## Keys

`a[b]` is a list of objects with `b`, `a[]` of values; `a{b}` an object, `a{}` one with names of
users as keys; `a*` any value; `a?` may be absent.
"""


def page() -> str:
    """The whole page."""
    return "\n".join([HEAD, *("\n".join(_section(title, FORMS[title])) for title in FORMS)])


def _section(title: str, forms: tuple[Form, ...]) -> Iterator[str]:
    yield f"### {title}\n"
    for form in forms:
        verbs = ", ".join(f"`{verb}`" for verb in form.verbs)
        yield f"- {verbs}{' *lines*' * form.lines}: {_keys(form)}"
    yield ""


def _keys(form: Form) -> str:
    texts = [form.page] if form.page else form.kinds
    shown = " or ".join(text if "`" in text or "](" in text else f"`{text}`" for text in texts)
    return f"{shown}; {form.note}" if form.note else shown


if __name__ == "__main__":
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(page(), encoding="utf-8")
