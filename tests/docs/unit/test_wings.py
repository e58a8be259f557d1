"""`make test WING=bag`: which tests a change in a room can break."""

from __future__ import annotations

import sys

import pytest

from tests.docs.unit.test_architecture import CORE, WINGS
from tests.support.repository import REPOSITORY
from tools import wings


@pytest.mark.parametrize(
    ("room", "users"),
    [
        ("smoke", {"faults", "smoke"}),
        ("bag", {"bag", "faults", "smoke"}),
        ("hosts", {"hosts", "doctor", "export", "faults", "smoke", "workspace"}),
        ("cli", {"cli", *WINGS}),
        ("control", {"control", "launch", "cli", *WINGS}),
        ("base", {*CORE, *WINGS}),
    ],
)
def test_those_that_may_import_a_room_use_it(room: str, users: set[str]):
    assert wings.users(room) == users


def test_what_a_change_in_a_wing_can_break():
    found = wings.tests_of("bag")

    whole = ["tests/bag/", "tests/cli/", "tests/docs/", "tests/faults/", "tests/smoke/"]
    assert found[:5] == whole
    assert "tests/system/test_bags.py" in found  # its verb
    assert "tests/base/unit/test_run_events.py" in found  # a module of smoke
    assert not [file for file in found[5:] if file.startswith(("tests/posix/", "tests/bag/"))]


def test_every_room_has_tests():
    assert [room for room in (*CORE, *WINGS) if not (REPOSITORY / f"tests/{room}/").exists()] == []


def test_an_unknown_wing_is_an_error_that_lists_them(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(sys, "argv", ["wings", "bga"])

    with pytest.raises(SystemExit) as ended:
        wings.main()

    said = capsys.readouterr()
    assert (ended.value.code, said.out) == (2, "")
    assert said.err.startswith("error: no wing 'bga'; wings: bag doctor export ")
