"""The command line of colcon."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.errors import UsageError
from launcher.workspace.building.build_place import Place
from launcher.workspace.building.colcon import colcon_arguments as colcon_words
from launcher.workspace.building.colcon import colcon_options


@pytest.fixture
def place(tmp_path: Path) -> Place:
    return Place(str(tmp_path), str(tmp_path / "src"))


def words(place: Place, *theirs: str) -> list[str]:
    return colcon_words.build(
        place, select=["a"], cmake_args=["-GNinja", "-DX=1"], links=True, words=theirs
    )


def cmake_args(command: list[str]) -> list[str]:
    return command[command.index("--cmake-args") + 1 :]


def test_definitions_for_cmake_are_joined_and_the_users_count(place: Place):
    command = words(place, "--cmake-args", "-DX=2", " --trace", "--parallel-workers", "1")

    assert cmake_args(command) == ["-GNinja", "-DX=1", "-DX=2", " --trace"]
    assert command[command.index("--parallel-workers") + 1] == "1"


def test_another_generator_replaces_ninja(place: Place):
    assert cmake_args(words(place, "--cmake-args", "-G", "Unix Makefiles")) == [
        "-DX=1",
        "-G",
        "Unix Makefiles",
    ]


@pytest.mark.parametrize("flag", ["--build-base", "--install-base=x", "--symlink-install"])
def test_options_that_the_launcher_has_itself(flag: str):
    with pytest.raises(UsageError) as raised:
        colcon_words.check([flag])
    assert raised.value.hint


@pytest.mark.parametrize(
    ("given", "hint"),
    [
        (["--nosuch"], None),
        (["--parallel-worker=2", "--packages-selct", "a"], "did you mean '--packages-select'?"),
        (["a"], "packages go behind --packages-select"),
    ],
)
def test_options_that_colcon_does_not_have(given: list[str], hint: str | None):
    with pytest.raises(UsageError) as raised:
        colcon_options.check(given)
    assert (raised.value.hint or "").startswith(hint or "")
    assert repr(given[0 if hint is None or given[0] == "a" else 1]) in raised.value.message


@pytest.mark.parametrize(
    "given",
    [
        [],
        ["--exec", "sequential", "--packages-select", "a"],
        ["--cmake-args", "-DX=2", "--trace", "--parallel-workers=1"],
    ],
)
def test_options_that_colcon_has(given: list[str]):
    colcon_options.check(given)


def test_only_words_that_change_what_is_built_count():
    given = ["--parallel-workers", "3", "--cmake-args", "-DX=2", "--event-handlers", "log+"]

    assert colcon_words.that_count(given) == ("--cmake-args", "-DX=2")


def test_a_value_may_follow_an_equals_sign():
    assert colcon_words.that_count(["--cmake-args=-DX=2", "--parallel-workers=3"]) == (
        "--cmake-args=-DX=2",
    )
    assert colcon_words.show(["--event-handlers=console_direct+"])
