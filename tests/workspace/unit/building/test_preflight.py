"""Which packages a build tries, and what is told about the others."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from launcher.base.errors import ExitCode, UsageError
from launcher.workspace.building import build_place, preflight
from launcher.workspace.building.colcon import colcon_arguments as colcon_words
from tests.workspace.unit.building.source_tree import (
    MINIMUM,
    interface_package,
    manifest,
    python_package,
    write,
)

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")

COLCON = pytest.mark.basic  # colcon is asked what it selects
CPP = MINIMUM + "project(cpp)\nfind_package(rclcpp REQUIRED)\n"


@pytest.fixture(autouse=True)
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """`broken` has a mistake, `user` needs it, `cpp` needs rclcpp, `alone` is right."""
    files = {
        **interface_package("broken", {"msg/A.msg": "int a"}),
        **python_package("user", "<depend>broken</depend>"),
        **python_package("alone"),
        "cpp/package.xml": manifest("cpp"),
        "cpp/CMakeLists.txt": CPP + "ament_package()\n",
    }
    write(tmp_path / "src", files)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def approved(*paths: str, words: tuple[str, ...] = (), keep_going: bool = False):
    found = preflight.approved(build_place.find(paths), {}, words, keep_going=keep_going)
    return [package.name for package in found.packages], [*found.refused]


def test_all_mistakes_are_reported_at_once_and_nothing_is_built(workspace: Path):
    with pytest.raises(preflight.BuildRefusedError) as raised:
        approved()

    assert [error.where for error in raised.value.errors] == [
        "src/broken/msg/A.msg:1",
        "src/cpp/CMakeLists.txt:3",
    ]
    assert raised.value.exit_code is ExitCode.USAGE
    assert (
        raised.value.render()
        .splitlines()[-1]
        .endswith("build --keep-going` builds the 1 package without mistakes")
    )
    assert not (workspace / "build").exists()


def test_keep_going_leaves_out_what_needs_a_refused_package(capsys: pytest.CaptureFixture[str]):
    assert approved(keep_going=True) == (["alone"], ["broken", "cpp", "user"])

    assert capsys.readouterr().err.count("error: ") == 2


@pytest.mark.parametrize("tag", ["exec_depend", "test_depend", "build_export_depend"])
def test_keep_going_builds_what_needs_a_refused_package_only_later(workspace: Path, tag: str):
    write(workspace / "src", python_package("later", f"<{tag}>broken</{tag}>"))
    write(workspace / "src", python_package("above", "<depend>later</depend>"))

    assert approved(keep_going=True) == (["alone", "later", "above"], ["broken", "cpp", "user"])


def test_only_the_named_packages_and_what_they_need_are_checked():
    assert approved("src/alone") == (["alone"], [])
    with pytest.raises(preflight.BuildRefusedError) as raised:
        approved("src/user")
    assert [error.package for error in raised.value.errors] == ["broken"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--packages-select", "alone"), []),
        (("--packages-select=alone",), []),
        (("--packages-select", "alone", "cpp"), ["cpp"]),
        (("--packages-up-to", "user"), ["broken"]),
        (("--packages-skip", "cpp"), ["broken"]),
        pytest.param(("--packages-select-regex", "al.*", "c.*"), ["cpp"], marks=COLCON),
        pytest.param(("--packages-above", "alone", "--executor", "sequential"), [], marks=COLCON),
        (("--executor", "sequential"), ["broken", "cpp"]),
    ],
)
def test_packages_that_colcon_is_to_leave_out_are_not_checked(
    words: tuple[str, ...], told: list[str]
):
    try:
        approved(words=words)
    except preflight.BuildRefusedError as error:
        assert [one.package for one in error.errors] == told
    else:
        assert told == []


@pytest.mark.basic
def test_options_that_select_no_package():
    with pytest.raises(UsageError, match=r"'--packages-select-regex z' selects no package"):
        approved(words=("--packages-select-regex", "z"))


@pytest.mark.parametrize("flag", ["--packages-select", "--packages-up-to", "--packages-skip"])
def test_names_that_no_package_has(flag: str, capsys: pytest.CaptureFixture[str]):
    """colcon ignores most of them; to skip a package that is not there is no mistake."""
    message = f"{flag}: there is no package 'alon' in the workspace\nhint: did you mean 'alone'?"
    if flag == "--packages-skip":
        approved(words=(flag, "alon", "broken", "cpp"))
        assert capsys.readouterr().err == f"warning: {message}\n"
    else:
        with pytest.raises(UsageError) as raised:
            approved(words=(flag, "alone", "alon"))
        assert raised.value.render() == f"error: {message}"


def test_a_package_whose_package_xml_cannot_be_read_is_reported_once(workspace: Path):
    """Not by the packages that need it."""
    text = manifest("lost").replace("<license>MIT</license>", "")
    write(workspace / "src", {"lost/package.xml": text})
    cmake = (
        MINIMUM
        + "project(needs)\nfind_package(ament_cmake REQUIRED)\nfind_package(lost REQUIRED)\n"
    )
    tags = manifest("needs", "<depend>lost</depend>")
    write(workspace / "src", {"needs/package.xml": tags, "needs/CMakeLists.txt": cmake})

    with pytest.raises(preflight.BuildRefusedError) as raised:
        approved("src/needs")

    assert [error.where for error in raised.value.errors] == ["src/lost/package.xml:2"]


UNREADABLE = [
    manifest("lost").replace("<license>MIT</license>", ""),
    manifest("lost").replace("</name>", ""),
    "<package",
    "",
]


@pytest.mark.parametrize("text", UNREADABLE, ids=["invalid", "unclosed", "cut off", "empty"])
@pytest.mark.parametrize(
    ("paths", "words", "built"),
    [
        ((), (), ["alone"]),
        (("src/needs", "src/alone"), (), ["alone"]),
        (("src/lost",), (), []),
        ((), ("--packages-select", "lost", "alone"), ["alone"]),
        ((), ("--packages-up-to", "needs", "alone"), ["alone"]),
    ],
)
def test_a_package_that_cannot_be_read_is_refused_with_those_that_need_it(
    workspace: Path,
    capsys: pytest.CaptureFixture[str],
    text: str,
    paths: tuple[str, ...],
    words: tuple[str, ...],
    built: list[str],
):
    for name in ("broken", "user", "cpp"):
        shutil.rmtree(workspace / "src" / name)
    write(workspace / "src", {"lost/package.xml": text})
    write(workspace / "src", python_package("needs", "<depend>lost</depend>"))

    with pytest.raises(preflight.BuildRefusedError) as raised:
        approved(*paths, words=words)
    packages, refused = approved(*paths, words=words, keep_going=True)

    assert len(raised.value.errors) == 1
    assert ("builds the 1 package" in raised.value.render()) == bool(built)
    assert "warning: " not in capsys.readouterr().err
    assert [name for name in packages if name not in refused] == built
    assert "lost" in refused
    assert ("needs" in refused) == (paths != ("src/lost",))


def test_a_cycle_refuses_all_packages_in_it(workspace: Path):
    write(workspace / "src", python_package("x", "<depend>y</depend>"))
    write(workspace / "src", python_package("y", "<test_depend>x</test_depend>"))
    write(workspace / "src", python_package("later", "<exec_depend>x</exec_depend>"))

    packages, refused = approved(keep_going=True)

    assert packages == ["alone", "later"]
    assert {"x", "y"} <= {*refused}


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ((), ("--packages-ignore", "b")),
        (("--executor", "sequential"), ("--executor", "sequential", "--packages-ignore", "b")),
        (
            ("--packages-select", "a", "b"),
            ("--packages-select", "a", "b", "--packages-ignore", "b"),
        ),
        (("--packages-ignore", "c"), ("--packages-ignore", "b", "c")),
        (("--packages-ignore=c",), ("--packages-ignore", "c", "b")),
    ],
)
def test_colcon_does_not_know_a_refused_package(words: tuple[str, ...], expected: tuple[str, ...]):
    assert colcon_words.ignoring(words, ["b"]) == expected
    assert colcon_words.ignoring(words, []) == words
