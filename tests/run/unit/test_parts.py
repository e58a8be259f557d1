"""The table of the parts of a run: every name in it leads somewhere."""

from __future__ import annotations

import ast

import pytest

from launcher.base.option import load
from launcher.run import part_verbs, parts
from launcher.run.part import Part
from tests.support.repository import REPOSITORY


def paths() -> list[str]:
    """What `module:name` stands for in the tables of names, lazy options and doors included."""
    files = [
        REPOSITORY / "launcher" / name
        for name in ("run/parts.py", "run/part_verbs.py", "base/verb_table.py")
    ]
    nodes = [node for file in files for node in ast.walk(ast.parse(file.read_text("utf-8")))]
    texts = [node.value for node in nodes if isinstance(node, ast.Constant)]
    return sorted(
        {t for t in texts if isinstance(t, str) and t.startswith("launcher.") and ":" in t}
    )


@pytest.mark.parametrize("path", paths())
def test_every_name_in_a_table_leads_to_an_object(path: str):
    assert callable(load(path))


def test_every_row_has_a_part():
    kinds = [load(row.part) for row in parts.ROWS]
    assert all(issubclass(kind, Part) for kind in kinds)
    assert len(set(kinds)) == len(kinds)


def test_options_and_verbs_of_parts_have_their_names_for_themselves():
    options = [option.flags for row in parts.ROWS for option in row.options]
    flags = [flag for some in options for flag in some]
    assert len(set(flags)) == len(flags)
    verbs = [verb.name for verb in part_verbs.VERBS]
    assert len(set(verbs)) == len(verbs)
    assert all(verb.serve for verb in part_verbs.VERBS)
