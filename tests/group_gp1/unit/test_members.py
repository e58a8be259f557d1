"""The reminder of `make test` that the group has to name its members."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.repository import REPOSITORY
from tools import members

HEAD = "# The fleet\n\n| name | matriculation number | e-mail |\n|---|---|---|\n"
MEMBER = "| Ada Lovelace | 1815 | ada@example.com |\n"
OTHER_TABLE = "\n| topic | type | QoS |\n|---|---|---|\n| /fleet/tasks | String | RELIABLE |\n"


@pytest.mark.parametrize(
    "rows",
    [
        pytest.param("", id="no row"),
        pytest.param("| | | |\n", id="an empty row"),
        pytest.param("| Ada Lovelace | | ada@example.com |\n", id="a row without a number"),
        pytest.param(OTHER_TABLE, id="another table below"),
    ],
)
def test_an_empty_table_is_a_warning_with_what_to_fill_in_and_where(rows: str, tmp_path: Path):
    page = tmp_path / "README.md"
    page.write_text(HEAD + rows, encoding="utf-8")

    warning = members.warning(page)

    assert warning is not None
    assert warning.startswith(f"warning: {page}: ")
    for word in ("name", "matriculation number", "e-mail", "<maintainer>", "package.xml"):
        assert word in warning


@pytest.mark.parametrize("rows", [MEMBER, "| | | |\n" + MEMBER, MEMBER + OTHER_TABLE])
def test_one_member_is_enough(rows: str, tmp_path: Path):
    page = tmp_path / "README.md"
    page.write_text(HEAD + rows, encoding="utf-8")

    assert members.warning(page) is None


def test_a_page_without_the_table_is_a_warning(tmp_path: Path):
    page = tmp_path / "README.md"
    page.write_text("# The fleet\n", encoding="utf-8")

    assert members.warning(page) is not None


def test_the_page_of_the_fleet_has_the_table():
    text = (REPOSITORY / members.PAGE).read_text(encoding="utf-8")
    assert sum(members.is_head(line) for line in text.splitlines()) == 1


def test_make_test_ends_with_it_and_its_exit_code_is_that_of_the_tests():
    makefile = (REPOSITORY / "Makefile").read_text(encoding="utf-8")
    recipe = makefile.partition("define run_tests\n")[2].partition("\nendef")[0]
    assert recipe.splitlines()[-2:] == ["\t$(PY) -m tools.members; \\", "\texit $$status"]
