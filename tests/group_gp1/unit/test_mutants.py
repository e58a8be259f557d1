"""The mutants of `python -m benchmarks mutants` fit the sources of the fleet."""

from __future__ import annotations

import pytest

from benchmarks.mutants.mutations import MUTANTS, SMOKE_FILES, Mutant
from tests.support.repository import REPOSITORY

PACKAGE = REPOSITORY / "group_gp1"


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_a_mutant_applies_and_compiles(mutant: Mutant):
    text = mutant.mutated(PACKAGE)
    compile(text, mutant.file, "exec")
    assert text != (PACKAGE / mutant.file).read_text(encoding="utf-8")
    assert mutant.smoke_file in SMOKE_FILES


def test_the_documentation_has_a_row_for_each_mutant():
    text = (REPOSITORY / "benchmarks/mutants/README.md").read_text(encoding="utf-8")
    assert [one.name for one in MUTANTS if f"| `{one.name}` |" not in text] == []


def test_mutants_have_names_of_their_own():
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS) == 27
