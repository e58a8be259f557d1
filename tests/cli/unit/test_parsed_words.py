"""Where the words of a command line end: libraries get values whose names mypy knows."""

from __future__ import annotations

import re

from tests.support.repository import REPOSITORY

# Words are parsed, or made into values, in these: verbs, and what several verbs share.
_VERBS = re.compile(r"launcher/(\w+/)+(verbs/.*|verbs?)\.py")
_SHARED = ("base/command_line", "launch/launch_options", "launch/target")
_OTHER = "launcher/language/frontends/parsers/"  # which have a type of the same name


def test_only_verbs_read_parsed_words():
    found = {
        str(path.relative_to(REPOSITORY))
        for path in (REPOSITORY / "launcher").rglob("*.py")
        if re.search(r"\bParsed\b", path.read_text("utf-8"))
    }
    shared = {f"launcher/{name}.py" for name in _SHARED}
    wrong = {name for name in found - shared if not _VERBS.fullmatch(name) and _OTHER not in name}

    assert wrong == set()
