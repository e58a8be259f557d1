"""`launcher build` builds what has changed, and nothing else."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.doctor.stale_workspace import inspect
from launcher.packages.distribution import ROS_VARIABLES, or_default
from launcher.packages.environment import environment, underlays
from launcher.packages.workspace import Workspace
from tests.workspace.process.building.small_packages import (
    build,
    built,
    cmake_package,
    files_package,
    message_package,
    python_package,
    write,
)


def write_sources(root: Path) -> Path:
    """A package of files, and a Python package that needs it."""
    files_package(root / "src", "files")
    python_package(root / "src", "nodes", "files")
    return root


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A workspace that is not built yet."""
    return write_sources(tmp_path)


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_sources(tmp_path_factory.mktemp("workspace"))


@pytest.fixture
def ready(workspace: Path) -> Iterator[Path]:
    """A workspace that is built: other tests have changed its sources, and they are as before."""
    built(workspace)
    yield workspace
    shutil.rmtree(workspace / "src")
    write_sources(workspace)


def greeting(root: Path) -> str:
    """What the installed program prints."""
    modules = [str(root / "build/nodes"), *map(str, root.glob("install/nodes/lib/*/site-packages"))]
    done = subprocess.run(
        [root / "install/nodes/lib/nodes/greet"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(modules)},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


@pytest.mark.thorough
def test_a_second_build_starts_nothing(root: Path):
    first = built(root)
    logs = sorted((root / "log").iterdir())

    second = built(root)

    assert first.summary == "2 packages: 2 built, 0 unchanged"
    assert second.summary == "2 packages: 0 built, 2 unchanged"
    assert sorted((root / "log").iterdir()) == logs  # colcon makes one in each run


@pytest.mark.thorough
def test_another_distribution_configures_the_packages_again(tmp_path: Path):
    lines = 'message(STATUS "for $ENV{ROS_DISTRO} $ENV{ROS_VERSION} $ENV{ROS_PYTHON_VERSION}")'
    cmake_package(tmp_path / "src", "p", lines)
    unset = {name: value for name, value in os.environ.items() if name not in ROS_VARIABLES}
    log = tmp_path / "log/latest_build/p/stdout.log"

    built(tmp_path, env=unset)
    assert f"for {or_default()} 2 3" in log.read_text()
    assert "1 unchanged" in built(tmp_path, env=unset).summary
    built(tmp_path, env={**unset, "ROS_DISTRO": "rolling"})
    assert "for rolling 2 3" in log.read_text()


@pytest.mark.thorough
def test_a_workspace_stays_on_those_that_it_was_built_on(tmp_path: Path):
    low, high = (Workspace(str(tmp_path / name), str(tmp_path / name / "install")) for name in "lh")
    python_package(tmp_path / "l/src", "low")
    python_package(tmp_path / "h/src", "high", "low")
    built(tmp_path / "l")
    built(tmp_path / "h", env=environment(low, os.environ))

    assert underlays(high) == [low.install]
    assert inspect(high, os.environ).changed == {}
    assert built(tmp_path / "h").summary == "1 package: 0 built, 1 unchanged"
    built(tmp_path / "h", "--all")
    assert underlays(high) == [low.install]
    named = {**os.environ, "AMENT_PREFIX_PATH": f"{tmp_path}/other"}
    reason = f"built on {low.install}, which is not in use now"
    assert inspect(high, named).changed == {"high": reason}


@pytest.mark.thorough
def test_other_messages_of_a_workspace_below_count(tmp_path: Path):
    low = Workspace(str(tmp_path / "l"), str(tmp_path / "l/install"))
    high = Workspace(str(tmp_path / "h"), str(tmp_path / "h/install"))
    lower = message_package(tmp_path / "l/src", "low")
    files_package(tmp_path / "h/src", "high")
    python_package(tmp_path / "h/src", "nodes")
    built(tmp_path / "l")
    built(tmp_path / "h", env=environment(low, os.environ))
    assert inspect(high, os.environ).changed == {}

    (lower / "msg/Number.msg").write_text("int32 a\nint64[500] more\n")
    built(tmp_path / "l")

    reason = "messages of a workspace below have changed"
    assert inspect(high, os.environ).changed == {"high": reason}
    assert built(tmp_path / "h").summary == "2 packages: 1 built, 1 unchanged"


@pytest.mark.thorough
def test_editing_linked_files_needs_no_build(ready: Path):
    write(ready / "src/nodes/nodes/greet.py", "def main():\n    print('good morning')\n")
    write(ready / "src/files/launch/demo.launch.xml", "<launch><!-- new --></launch>\n")

    assert greeting(ready) == "good morning"
    assert "new" in (ready / "install/files/share/files/launch/demo.launch.xml").read_text()
    assert built(ready).summary == "2 packages: 0 built, 2 unchanged"


@pytest.mark.thorough
def test_a_new_file_is_installed(ready: Path):
    write(ready / "src/files/launch/second.launch.xml", "<launch/>\n")

    assert built(ready).summary == "2 packages: 1 built, 1 unchanged"
    assert (ready / "install/files/share/files/launch/second.launch.xml").is_file()


@pytest.mark.thorough
def test_a_removed_file_is_removed_from_the_installation(ready: Path):
    (ready / "src/files/launch/demo.launch.xml").rename(ready / "src/files/launch/other.launch.xml")

    built(ready)

    installed = (ready / "install/files/share/files/launch").iterdir()
    assert [path.name for path in installed] == ["other.launch.xml"]


@pytest.mark.thorough
def test_a_file_removed_after_a_failed_build_is_removed_from_the_installation(ready: Path):
    lists = ready / "src/files/CMakeLists.txt"
    text = lists.read_text()
    write(lists, f"{text}message(FATAL_ERROR stop)\n")
    assert build(ready).code == 1
    facts = inspect(Workspace(str(ready), str(ready / "install")), os.environ)
    assert facts.changed["files"] == "the last build is not complete"

    write(lists, text)
    (ready / "src/files/launch/demo.launch.xml").rename(ready / "src/files/launch/other.launch.xml")
    built(ready)

    installed = (ready / "install/files/share/files/launch").iterdir()
    assert [path.name for path in installed] == ["other.launch.xml"]


@pytest.mark.thorough
@pytest.mark.parametrize(
    "lost", ["install", "build", "install/files/share/files/launch/demo.launch.xml", "log"]
)
def test_what_was_removed_is_made_again(ready: Path, lost: str):
    path = ready / lost
    shutil.rmtree(path) if path.is_dir() else path.unlink()

    built(ready)

    assert greeting(ready) == "hello"
    assert (ready / "install/files/share/files/launch/demo.launch.xml").is_file()
    assert built(ready).summary == "2 packages: 0 built, 2 unchanged"


@pytest.mark.thorough
def test_an_edited_manifest_is_built(ready: Path):
    manifest = ready / "src/files/package.xml"
    write(manifest, manifest.read_text().replace("0.1.0", "0.2.0"))

    assert built(ready).summary == "2 packages: 1 built, 1 unchanged"
    assert "0.2.0" in (ready / "install/files/share/files/package.xml").read_text()


@pytest.mark.thorough
def test_a_time_stamp_alone_is_no_change(ready: Path):
    for path in ready.glob("src/**/*"):
        path.touch()

    assert built(ready).summary == "2 packages: 0 built, 2 unchanged"


@pytest.mark.thorough
def test_a_moved_workspace_is_built_again(root: Path, tmp_path: Path):
    moved = tmp_path.parent / f"{tmp_path.name}-moved"
    built(root)
    root.rename(moved)

    assert built(moved).summary == "2 packages: 2 built, 0 unchanged"
    assert greeting(moved) == "hello"
    texts = [path.read_text() for path in moved.glob("build/*/CMakeCache.txt")]
    assert texts and not any(f"{root}/" in text for text in texts)


@pytest.mark.thorough
def test_copies_instead_of_links(root: Path):
    built(root)
    file = root / "install/files/share/files/launch/demo.launch.xml"
    assert file.is_symlink()

    assert built(root, "--copy").summary == "2 packages: 2 built, 0 unchanged"
    assert not file.is_symlink()
    write(root / "src/nodes/nodes/greet.py", "def main():\n    print('good morning')\n")
    assert greeting(root) == "hello"
    assert built(root, "--copy").summary == "2 packages: 1 built, 1 unchanged"
    assert greeting(root) == "good morning"


@pytest.mark.thorough
def test_the_dependents_of_a_changed_package_are_built(tmp_path: Path):
    first = files_package(tmp_path / "src", "first")
    cmake_package(tmp_path / "src", "second", "find_package(first REQUIRED)", depends=["first"])
    built(tmp_path)
    (first / "CMakeLists.txt").open("a").write("# changed\n")

    assert built(tmp_path).summary == "2 packages: 2 built, 0 unchanged"


@pytest.mark.thorough
def test_a_package_of_a_folder_is_built_with_what_it_depends_on(root: Path):
    python_package(root / "src", "other")

    assert built(root, "src/nodes").summary == "2 packages: 2 built, 0 unchanged"
    assert built(root / "src/nodes/nodes").summary == "2 packages: 0 built, 2 unchanged"
    assert built(root / "src").summary == "3 packages: 1 built, 2 unchanged"


@pytest.mark.thorough
def test_a_lone_package_is_built_in_its_folder(tmp_path: Path):
    folder = files_package(tmp_path, "lone", languages="C CXX")

    assert built(folder).summary == "1 package: 1 built, 0 unchanged"
    assert (folder / "install/lone/share/lone/launch/demo.launch.xml").is_file()
    assert built(folder / "launch").summary == "1 package: 0 built, 1 unchanged"


@pytest.mark.thorough
def test_options_of_colcon_follow_two_dashes(root: Path):
    done = built(root, "--", "--packages-select", "files", "--cmake-args", "-DMY_OPTION=7")

    assert done.summary == "1 package: 1 built, 0 unchanged"
    assert not (root / "install/nodes").exists()
    assert "MY_OPTION:UNINITIALIZED=7" in (root / "build/files/CMakeCache.txt").read_text()


@pytest.mark.thorough
def test_packages_that_colcon_does_not_select_stay_as_they_are(ready: Path):
    (ready / "src/files/launch/demo.launch.xml").unlink()
    write(ready / "src/files/launch/other.launch.xml", "<launch/>\n")

    built(ready, "--", "--packages-select", "nodes")

    assert (ready / "install/files/share/files").is_dir()
    assert built(ready).summary == "2 packages: 1 built, 1 unchanged"


@pytest.mark.thorough
def test_colcon_writes_to_the_terminal_if_it_is_told_to(root: Path):
    done = built(root, "--", "--event-handlers", "console_direct+")

    assert "Starting >>> files" in done.out


@pytest.mark.thorough
def test_a_workspace_that_merges_stays_so(root: Path):
    built(root, "--", "--merge-install")
    write(root / "src/files/launch/second.launch.xml", "<launch/>\n")

    assert built(root).code == 0
    assert (root / "install/share/files/launch/second.launch.xml").is_file()


@pytest.mark.thorough
def test_a_failed_package_does_not_hold_up_others(root: Path):
    cmake_package(root / "src", "bad", 'message(FATAL_ERROR "no such luck")')
    cmake_package(root / "src", "behind", depends=["bad"])

    done = build(root)

    assert done.code == 1
    assert done.summary == (
        "4 packages: 2 built, 0 unchanged, 1 failed (bad), 1 not tried (behind)"
    )
    assert "no such luck" in done.err
    assert build(root).summary.endswith("2 unchanged, 1 failed (bad), 1 not tried (behind)")


@pytest.mark.thorough
def test_a_package_that_only_colcon_selected_fails(root: Path):
    cmake_package(root / "src", "bad", 'message(FATAL_ERROR "no such luck")')

    done = build(root, "src/files", "--", "--packages-select", "bad")

    assert (done.code, done.summary) == (1, "1 package: 0 built, 0 unchanged, 1 failed (bad)")
    assert "no such luck" in done.err


@pytest.mark.thorough
def test_files_beside_src_do_not_hide_modules_of_python(root: Path):
    write(root / "json.py", "raise SystemExit('not the module of Python')\n")

    assert built(root / "src", str(root)).summary == "2 packages: 2 built, 0 unchanged"


@pytest.mark.thorough
def test_the_path_may_have_spaces_and_umlauts(tmp_path: Path):
    root = tmp_path / "Übung 1 (neu)"
    files_package(root / "src", "files")
    python_package(root / "src", "nodes")

    built(root)

    assert greeting(root) == "hello"
