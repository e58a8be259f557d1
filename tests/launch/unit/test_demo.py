"""`demo`: which package it launches, and what it refuses."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from launcher.cli.dispatch import main
from launcher.packages import source_packages
from tests.support.repository import REPOSITORY


@pytest.fixture
def in_wheel(tmp_path: Path, monkeypatch) -> Path:
    """An installed launcher: beside it is no package, in it one that is nowhere else."""
    package = tmp_path / "launcher/demo_package"
    (package / "launch").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>the_fleet</name></package>")
    (package / "setup.py").write_text("from setuptools import setup\nsetup(name='the_fleet')\n")
    (package / "launch/system.launch.py").write_text(
        "from launch import LaunchDescription\n"
        "def generate_launch_description(): return LaunchDescription()\n"
    )
    monkeypatch.setattr(source_packages, "_OURS", str(tmp_path))
    monkeypatch.setattr(source_packages, "_IN_WHEEL", str(package))
    monkeypatch.setattr(source_packages, "_chosen", {})
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    return package


def test_in_a_clone_it_is_the_fleet_of_the_clone(capsys, tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    assert main(["demo", "--print", "start_robot_2:=false"]) == 0
    assert f"{REPOSITORY}/launch/system.launch.py" in capsys.readouterr().out


def test_an_installed_launcher_has_it_as_a_folder_of_its_own(in_wheel: Path, capsys):
    assert main(["demo", "--print"]) == 0
    assert str(in_wheel) in main_out(capsys, "args", "the_fleet", "no.launch.py")
    assert "available: system.launch.py" in main_out(capsys, "args", "the_fleet", "no.launch.py")


def test_the_folder_is_in_no_list_of_packages(in_wheel: Path):
    assert source_packages.find("the_fleet") == str(in_wheel)
    assert "the_fleet" not in dict(source_packages.around())


def test_a_package_of_its_name_below_the_working_directory_is_not_taken(in_wheel: Path, capsys):
    other = Path("somewhere/the_fleet")
    shutil.copytree(in_wheel, other)
    assert source_packages.find("the_fleet") == str(other.absolute())
    assert main(["demo", "--print"]) == 0
    assert capsys.readouterr().out.startswith(f"{in_wheel}/launch/")
    assert source_packages.find("the_fleet") == str(in_wheel)


def test_without_it_the_repair_is_named(in_wheel: Path, capsys):
    (in_wheel / "package.xml").unlink()

    assert main_out(capsys, "demo") == (
        "error: this installation of the launcher has no demo\n"
        "hint: an old pip has left it out: update pip, and install the launcher again\n"
    )


@pytest.mark.parametrize("word", ["--help", "-h"])
def test_its_help_is_short(capsys, word: str):
    assert main(["demo", "enable_debug:=true", word]) == 0
    out = capsys.readouterr().out
    assert "enable_debug:=true" in out
    assert len(out.splitlines()) < 15


def test_a_package_called_demo_is_launched_by_launch(capsys):
    assert main_out(capsys, "demo", "demo.launch.py") == (
        "error: `demo` takes no launch file: 'demo.launch.py'\n"
        "hint: if it is in a package called demo: python -m launcher launch demo demo.launch.py\n"
    )


def main_out(capsys, *words: str) -> str:
    """What a wrong command line prints."""
    capsys.readouterr()
    assert main(words) == 2
    return capsys.readouterr().err
