"""Which workspace a path belongs to, and which packages it names."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.errors import UsageError
from launcher.packages import workspace
from launcher.workspace.building import build_place
from tests.workspace.process.building.small_packages import files_package, write


@pytest.fixture
def root(tmp_path: Path) -> Path:
    files_package(tmp_path / "ws/src", "one")
    files_package(tmp_path / "ws/src/group", "two")
    return tmp_path / "ws"


@pytest.mark.parametrize(
    ("path", "named"),
    [
        ("", []),
        ("src", []),
        ("src/one", ["src/one"]),
        ("src/one/launch", ["src/one"]),
        ("src/group", ["src/group/two"]),
    ],
)
def test_a_folder_of_a_workspace(root: Path, path: str, named: list[str]):
    found = build_place.find([str(root / path)])

    assert found.root == str(root)
    assert found.base == str(root / "src")
    assert [*found.named] == [str(root / one) for one in named]


@pytest.mark.parametrize("path", ["", "one"])
@pytest.mark.parametrize(("pwd", "is_found"), [("ws/src", True), ("real", False), ("ws", False)])
def test_src_may_be_a_link_that_the_shell_went_through(
    root: Path, path: str, pwd: str, is_found: bool, monkeypatch: pytest.MonkeyPatch
):
    """$PWD counts if it is the working directory."""
    write(root / "install/.colcon_install_layout", "isolated\n")
    (root / "src").rename(root.parent / "real")
    (root / "src").symlink_to("../real")
    monkeypatch.chdir(root / "src" / path)
    monkeypatch.setenv("PWD", str(root.parent / pwd / path))

    there = workspace.find()
    assert (there.root if there else None) == (str(root) if is_found else None)
    if is_found:
        assert build_place.find([]).root == build_place.find(["."]).root == str(root)
        assert [*build_place.find([]).named] == ([str(root / "src/one")] if path else [])


def test_a_folder_beside_src_needs_a_workspace_that_was_built(root: Path):
    (root / "docs").mkdir()
    with pytest.raises(UsageError, match="no workspace"):
        build_place.find([str(root / "docs")])

    write(root / "install/.colcon_install_layout", "isolated\n")
    assert build_place.find([str(root / "docs")]).root == str(root)


def test_above_a_workspace_the_error_names_it(root: Path, monkeypatch):
    monkeypatch.chdir(root.parent)
    with pytest.raises(UsageError, match="no workspace") as caught:
        build_place.find([])
    assert caught.value.hint == "there is one in ./ws: cd ws, or --workspace ws"


def test_the_variable_names_a_workspace_below_the_home_folder(root: Path, monkeypatch):
    monkeypatch.setenv("HOME", str(root.parent))
    monkeypatch.setenv("LAUNCHER_WORKSPACE", "~/ws")
    assert build_place.find([]).root == str(root)


def test_a_package_in_the_sources_of_the_user_is_alone_until_these_are_a_workspace(
    root: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("HOME", str(root))
    package = root / "src/one"
    assert build_place.find([str(package)]).root == str(package)
    assert build_place.find([str(root / "src")]).root == str(root)

    write(root / "install/.colcon_install_layout", "isolated\n")
    assert build_place.find([str(package)]).root == str(root)


def test_a_link_to_a_workspace_is_the_workspace(root: Path):
    link = root.parent / "link"
    link.symlink_to(root)
    found = build_place.find([str(link / "src/one")])
    assert (found.root, found.base) == (str(root), str(root / "src"))


def test_a_workspace_without_packages(tmp_path: Path):
    write(tmp_path / "install/.colcon_install_layout", "isolated\n")
    with pytest.raises(UsageError, match="has no packages in src/ any more"):
        build_place.find([str(tmp_path)])


def test_a_package_alone_is_its_own_workspace(tmp_path: Path):
    folder = files_package(tmp_path, "alone")
    (folder / "src").mkdir()  # as C++ packages have it

    for path in (folder, folder / "src", folder / "launch"):
        found = build_place.find([str(path)])
        assert (found.root, found.base, found.named) == (str(folder), str(folder), ())


def test_several_packages_of_one_workspace(root: Path):
    found = build_place.find([str(root / "src/one"), str(root / "src/group/two")])

    assert [*found.named] == [str(root / "src/one"), str(root / "src/group/two")]


def test_paths_of_two_workspaces(root: Path, tmp_path: Path):
    other = files_package(tmp_path / "other/src", "three")

    with pytest.raises(UsageError, match="another workspace"):
        build_place.find([str(root), str(other)])


@pytest.mark.parametrize(
    ("character", "why"),
    [
        (":", "search paths such as PYTHONPATH separate"),
        (";", "lists of CMake separate"),
        ('"', "strings of CMake end"),
        ("\\", "escape sequence of CMake"),
        ("\n", "control characters"),
    ],
)
def test_a_path_that_cmake_cannot_take(tmp_path: Path, character: str, why: str):
    files_package(tmp_path / f"a{character}b/src", "one")

    with pytest.raises(UsageError, match="cannot be built in a folder with") as raised:
        build_place.find([str(tmp_path / f"a{character}b")])
    assert why in (raised.value.hint or "")


@pytest.mark.parametrize("path", ["nothing", "file", "empty", "bare"])
def test_a_path_without_packages(tmp_path: Path, path: str):
    write(tmp_path / "file", "")
    (tmp_path / "empty/src").mkdir(parents=True)
    (tmp_path / "bare").mkdir()

    with pytest.raises(UsageError) as raised:
        build_place.find([str(tmp_path / path)])

    assert raised.value.hint
