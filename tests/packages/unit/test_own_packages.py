"""Packages that are used from their source folder, and what is said about those not found."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.base.errors import ExecutableNotFoundError, PackageNotFoundError, UsageError
from launcher.base.program import program
from launcher.language.compat import vocabulary
from launcher.language.frontends.locate import locate
from launcher.packages import finder, is_reading_once, overlay, source_packages
from launcher.packages.distribution import or_default
from launcher.packages.package_origins import needs_ros
from tests.support.own_package import write_package

MANIFEST = "<package><name>{}</name></package>"


@pytest.fixture(autouse=True)
def _own_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is kept from other tests; the working directory holds no package."""
    (tmp_path / "tmp").mkdir()
    (tmp_path / "work").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "tmp"))
    monkeypatch.chdir(tmp_path / "work")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "none"))


@pytest.fixture
def work(tmp_path: Path) -> Path:
    return tmp_path / "work"


def made(folder: Path, **files: str) -> Path:
    """A source folder with these files; `_` stands for a dot, `__` for a slash."""
    for name, text in files.items():
        file = folder / name.replace("__", "/").replace("_", ".")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(MANIFEST.format(folder.name))
    return folder


# ---- what setup.py would install

SETUP_PY = {
    "loops and helper functions": """
import os
from setuptools import setup
def below(folder):
    return [(os.path.join("share/bot", path), [os.path.join(path, n) for n in names])
            for path, _, names in os.walk(folder) if names]
setup(name="bot", data_files=[("share/bot", ["package.xml"])] + below("launch"),
      entry_points={"console_scripts": ["talk = bot.talk:main"]})
""",
    "commands, distutils and a guard": """
from distutils.core import setup
from setuptools import find_packages, Extension
from setuptools.command.build_py import build_py
class Build(build_py):
    def run(self):
        super().run()
if __name__ == "__main__":
    print("noise")
    setup(name="bot", cmdclass={"build_py": Build}, packages=find_packages(),
          data_files=[("share/bot/launch", ["launch/a.launch.py"])],
          entry_points="[console_scripts]\\ntalk = bot.talk:main\\n")
""",
}


@pytest.mark.parametrize("text", SETUP_PY.values(), ids=SETUP_PY)
def test_setup_py_is_run_without_setuptools(work: Path, text: str):
    made(work / "bot", setup_py=text, launch__a_launch_py="")

    own = finder.own_package("bot", os.environ)

    assert own is not None and own.contents.problem is None
    assert own.share == str(work / "bot")
    assert own.installs(str(work / "bot/launch/a.launch.py"))
    assert os.access(f"{own.prefix}/lib/bot/talk", os.X_OK)


CONFIGURED = {
    "setup_cfg": """
[options.data_files]
share/bot/launch = starts/*.launch.py
share/bot/config =
    conf/a.yaml
    conf/b.yaml
[options.entry_points]
console_scripts =
    talk = bot.talk:main
""",
    "pyproject_toml": """
[project]
name = "bot"
[project.scripts]
talk = "bot.talk:main"
[tool.setuptools.data-files]
"share/bot/launch" = ["starts/*.launch.py"]
"share/bot/config" = ["conf/a.yaml", "conf/b.yaml"]
""",
}


@pytest.mark.parametrize("file", CONFIGURED)
def test_data_files_may_be_in_a_configuration_file(work: Path, file: str):
    texts = {file: CONFIGURED[file], "starts__x_launch_py": "", "conf__a_yaml": ""}
    made(work / "bot", conf__b_yaml="", **texts)

    share = finder.share_directory("bot", os.environ)

    assert share != work / "bot"
    found = {str(path.relative_to(share)) for path in share.rglob("*") if path.is_file()}
    assert found == {"launch/x.launch.py", "config/a.yaml", "config/b.yaml"}
    assert finder.executables("bot", os.environ) == ["talk"]
    assert locate(["bot", "x.launch.py"], os.environ) == share / "launch/x.launch.py"


def test_programs_among_the_data_files_are_executables(work: Path):
    text = (
        "from setuptools import setup\n"
        "setup(data_files=[('lib/bot', ['tool'])], scripts=['scripts/other'])\n"
    )
    made(work / "bot", setup_py=text, tool="#!/bin/sh\n", scripts__other="#!/bin/sh\n")
    for name in ("tool", "scripts/other"):
        (work / "bot" / name).chmod(0o755)

    program = finder.find_executable("bot", "other", os.environ)

    assert program.resolve() == work / "bot/scripts/other"
    assert finder.executables("bot", os.environ) == ["other", "tool"]


def test_a_package_of_cmake_that_is_not_built_says_so(work: Path):
    made(work / "bot", CMakeLists_txt="", launch__a_launch_xml="<launch/>")

    assert finder.share_directory("bot", os.environ) == work / "bot"
    with pytest.raises(ExecutableNotFoundError) as caught:
        finder.find_executable("bot", "talk", os.environ)
    assert caught.value.message == f"executable 'talk' not found in the source folder '{work}/bot'"
    assert caught.value.hint == f"{work}/bot is not built: {program()} build bot"


def test_a_file_that_setup_py_leaves_out_is_reported(work: Path, capsys):
    source = write_package(work, "bot")
    (source / "extra.launch.xml").write_text("<launch/>")
    moved = write_package(work, "moved", moved=True)
    (moved / "extra.launch.xml").write_text("<launch/>")

    assert locate(["bot", "extra.launch.xml"], os.environ) == source / "extra.launch.xml"
    assert "extra.launch.xml is not among the data_files of" in capsys.readouterr().err
    with pytest.raises(Exception, match="was not found in the share directory") as caught:
        locate(["moved", "extra.launch.xml"], os.environ)
    assert caught.value.hint == (
        f"{moved}/extra.launch.xml is not among the data_files of {moved}/setup.py"
    )


def test_the_name_of_a_launch_file_is_enough(work: Path):
    write_package(work, "bot")
    write_package(work, "moved", moved=True)

    assert locate(["bot_xml"], os.environ) == work / "bot/launch/bot_xml.launch.xml"
    assert locate(["moved_xml"], os.environ).resolve() == (
        work / "moved/files/starts/moved_xml.launch.xml"
    )


# ---- the prefix of links


def test_the_prefix_is_made_again_only_after_a_change(work: Path, monkeypatch):
    source = write_package(work, "bot", moved=True)
    runs: list[object] = []
    real = subprocess.run

    def counted(*args, **named):
        runs.append(args)
        return real(*args, **named)

    monkeypatch.setattr(subprocess, "run", counted)
    first = finder.share_directory("bot", os.environ)
    assert finder.share_directory("bot", os.environ) == first
    assert len(runs) == 1

    (source / "files" / "q.yaml").write_text("")
    second = finder.share_directory("bot", os.environ)
    assert len(runs) == 2
    assert second != first and (second / "config/q.yaml").is_file()
    assert (first / "config/p.yaml").is_file()  # of a run that still uses it


def test_a_prefix_that_was_cleaned_up_is_completed(work: Path):
    write_package(work, "bot", moved=True)
    share = finder.share_directory("bot", os.environ)
    shutil.rmtree(share / "config")

    assert finder.share_directory("bot", os.environ) == share
    assert (share / "config/p.yaml").is_file()


def test_a_folder_of_somebody_else_is_not_used(work: Path, tmp_path: Path):
    write_package(work, "bot")
    taken = tmp_path / "tmp" / f"{source_packages.OVERLAY_FOLDER}{os.getuid()}"
    taken.mkdir()
    taken.chmod(0o777)

    prefix = finder.package_prefix("bot", os.environ)

    assert taken not in prefix.parents


def test_the_prefix_is_announced_to_children_but_not_shown_as_a_change(work: Path, tmp_path: Path):
    write_package(work, "bot")
    prefix = finder.package_prefix("bot", os.environ)

    assert os.environ["AMENT_PREFIX_PATH"] == f"{tmp_path}/none:{prefix}"
    assert overlay.without_overlays(os.environ["AMENT_PREFIX_PATH"]) == f"{tmp_path}/none"
    assert finder.package_prefix("bot", os.environ) == prefix


def test_a_launcher_in_a_launch_finds_the_packages_of_the_outer_one(work: Path, monkeypatch):
    write_package(work, "bot")
    prefix = finder.package_prefix("bot", os.environ)
    (work / "deep").mkdir()
    monkeypatch.chdir("/")

    assert finder.package_prefix("bot", os.environ) == prefix
    assert (finder.share_directory("bot", os.environ) / "launch").is_dir()


def test_an_interpreter_with_a_blank_in_its_path_runs_the_programs(work: Path, monkeypatch):
    write_package(work, "bot")
    python = work / "a folder" / "python"
    python.parent.mkdir()
    python.symlink_to(sys.executable)
    (work / "bot/bot/talker.py").write_text("def main():\n    print('ran')\n")
    monkeypatch.setattr(sys, "executable", str(python))

    program = finder.find_executable("bot", "bot_talker", os.environ)

    assert subprocess.check_output([str(program)], text=True) == "ran\n"


# ---- where source folders are searched


def test_packages_below_beside_and_in_a_workspace_are_found(work: Path, monkeypatch):
    for place in ("ws/src/one", "ws/src/group/two", "ws/build/three", "ws/src/.hidden/four"):
        made(work / place)
    made(work / "ws/src/ignored/five")
    (work / "ws/src/ignored/COLCON_IGNORE").touch()
    made(work / "ws/src/one/vendor/six")

    for start in ("ws", "ws/src/one", "ws/src/group/two", "ws/build"):
        monkeypatch.chdir(work / start)
        names = {
            name for name, folder in source_packages.around() if folder.startswith(f"{work}/ws/src")
        }
        assert names == {"one", "two"}, start


def test_the_search_ends_in_a_large_folder(work: Path, monkeypatch):
    monkeypatch.setattr(source_packages, "_MAX_FOLDERS", 3)
    for index in range(9):
        made(work / f"pkg{index}")

    found = [name for name, folder in source_packages.around() if folder.startswith(str(work))]

    assert found == ["pkg0", "pkg1", "pkg2"]


def test_what_looks_at_all_packages_reads_folders_and_installations_once(work: Path, monkeypatch):
    for index in range(4):
        made(work / f"src/pkg{index}")
    read: list[str | None] = []
    folders, distributions = source_packages._folders_around, source_packages.distributions
    monkeypatch.setattr(
        source_packages, "_folders_around", lambda: (read.append("/"), folders())[1]
    )
    monkeypatch.setattr(
        source_packages,
        "distributions",
        lambda name=None: (read.append(name), distributions(name))[1],
    )

    with pytest.raises(UsageError):
        locate(["nope"], os.environ)

    assert (read.count("/"), read.count(None)) == (1, 1)
    assert not is_reading_once()
    assert [name for name, _ in source_packages.around() if name == "pkg3"] == ["pkg3"]


def test_packages_of_merged_and_isolated_workspaces_are_found(tmp_path: Path):
    merged, isolated = tmp_path / "merged", tmp_path / "isolated"
    for prefix, name in ((merged, "one"), (isolated / "two", "two")):
        marker = prefix / source_packages.MARKERS / name
        marker.parent.mkdir(parents=True)
        marker.touch()
    env = {"COLCON_PREFIX_PATH": f"{merged}:{isolated}"}

    assert finder.share_directory("one", env) == merged / "share/one"
    assert finder.share_directory("two", env) == isolated / "two/share/two"


# ---- packages that are not found


def hint_for(name: str) -> str:
    with pytest.raises(PackageNotFoundError) as caught:
        finder.share_directory(name, os.environ)
    return caught.value.hint or ""


@pytest.mark.parametrize(
    ("name", "near"),
    [("grup_gp1", "group_gp1"), ("botanics", "botanic"), ("rclpyy", "rclpy")],
    ids=["editable", "source", "wheel"],
)
def test_near_names_are_suggested_among_all_packages(work: Path, name: str, near: str):
    made(work / "botanic")

    assert hint_for(name) == f"did you mean '{near}'?"


@pytest.mark.parametrize("name", ["turtlesim", "nav2_bringup", "rclcpp_components", "rviz2"])
def test_packages_without_a_wheel_are_said_to_need_ros(name: str):
    hint = hint_for(name)

    assert (
        f"installation of ROS 2 (apt install ros-{or_default()}-{name.replace('_', '-')})" in hint
    )
    assert hint.endswith("runs there as well")


def test_well_known_names_are_recognized_as_a_whole():
    known = "demo_nodes_cpp demo_nodes_py robot_state_publisher tf2_ros ros_gz_bridge"
    assert all(map(needs_ros, known.split()))
    others = "my_xacro rclpy std_msgs nav2 camera_driver joystick"
    assert not any(map(needs_ros, others.split()))


# ---- ament_index_python, and the tools of ROS


def test_ament_index_python_finds_them_while_a_launch_file_is_read(work: Path):
    source = write_package(work, "bot")
    moved = write_package(work, "moved", moved=True)
    module = importlib.import_module("ament_index_python.packages")
    original = module.get_package_share_directory

    with vocabulary():
        assert module.get_package_share_directory("bot") == str(source)
        assert module.get_package_share_path("bot") == source
        assert module.get_package_share_directory("bot") == str(source)  # now it is announced
        share = module.get_package_share_directory("moved")
        assert share == str(finder.share_directory("moved", os.environ)) != str(moved)
        assert os.path.isdir(module.get_package_prefix("bot"))
        for function in (module.get_package_prefix, module.get_package_share_directory):
            with pytest.raises(module.PackageNotFoundError) as caught:
                function("group_gp2")
            assert caught.value.message == "package 'group_gp2' not found"
            assert source_packages.OVERLAY_FOLDER not in str(caught.value)
            assert caught.value.hint == "did you mean 'group_gp1'?"

    assert module.get_package_share_directory is original


def test_the_functions_of_ros2pkg_know_all_packages(work: Path):
    write_package(work, "bot")
    with vocabulary():
        api = importlib.import_module("ros2pkg.api")
        assert {"bot", "group_gp1"} <= set(api.get_package_names())
        prefix = api.get_prefix_path("bot")
        assert api.get_executable_paths(package_name="bot") == [f"{prefix}/lib/bot/bot_talker"]
        assert api.get_prefix_path("no_such_package") is None
        with pytest.raises(api.PackageNotFound):
            api.get_executable_paths(package_name="no_such_package")
    assert "ros2pkg" not in sys.modules


def test_the_functions_of_ros2launch_find_files_and_print_arguments(work: Path, capsys):
    source = write_package(work, "bot")
    with vocabulary():
        api = importlib.import_module("ros2launch.api")
        find = api.get_share_file_path_from_package
        path = find(package_name="bot", file_name="bot.launch.py")
        assert path == str(source / "launch/bot.launch.py")
        with pytest.raises(FileNotFoundError, match="was not found in the share directory"):
            find(package_name="bot", file_name="none.launch.py")
        (source / "bot.launch.py").touch()
        with pytest.raises(api.MultipleLaunchFilesError) as caught:
            find(package_name="bot", file_name="bot.launch.py")
        assert len(caught.value.paths) == 2
        assert api.is_launch_file(path) and not api.is_launch_file(f"{source}/setup.py")
        names = api.LaunchFileNameCompleter()("", type("Parsed", (), {"package_name": "bot"}))
        assert sorted(set(names)) == ["bot.launch.py", "bot_xml.launch.xml"]
        parse = importlib.import_module("ros2launch.api.api").parse_launch_arguments
        assert list(parse(["a:=1", "b:=2:=3", "a:=4"])) == [("a", "4"), ("b", "2:=3")]
        with pytest.raises(RuntimeError, match="malformed launch argument 'x'"):
            parse(["x"])
        api.print_arguments_of_launch_file(launch_file_path=path)
    said = "'who':\n        no description given\n        (default: 'nobody')"
    assert said in capsys.readouterr().out


def test_an_installed_ros2pkg_goes_before_ours(work: Path, monkeypatch):
    installed = work / "site" / "ros2pkg"
    installed.mkdir(parents=True)
    (installed / "__init__.py").touch()
    (installed / "api.py").write_text("get_prefix_path = 'the installed one'\n")
    monkeypatch.syspath_prepend(installed.parent)

    with vocabulary():
        assert importlib.import_module("ros2pkg.api").get_prefix_path == "the installed one"
    for name in ("ros2pkg", "ros2pkg.api"):
        del sys.modules[name]  # it stays, as any import does
