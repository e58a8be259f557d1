"""What is read of installed distributions, compared with `importlib.metadata`."""

from __future__ import annotations

import os
import sys
import zipfile
from importlib import metadata
from pathlib import Path

import pytest

from launcher.packages import is_reading_once, once, reading_once
from launcher.packages.dist_info import DistInfo, installed

POINTS = """
# the programs
[console_scripts]
talk = pkg.talker:main
listen=pkg.listener : Listener.main [extra]

[empty]
[launcher.programs]
odd.name = pkg
"""
Facts = tuple[str, str, "list[tuple[str, ...]]"]


def ours(found: list[DistInfo]) -> list[Facts]:
    return sorted(
        (
            one.folder,
            one.read_text("METADATA") or "",
            sorted((p.group, p.name, p.module, p.attr) for p in one.points),
        )
        for one in found
    )


def theirs(found: list[metadata.Distribution]) -> list[Facts]:
    return sorted(
        (
            os.path.normpath(str(one.locate_file(""))),
            one.read_text("METADATA") or "",
            sorted((p.group, p.name, p.module, p.attr or "") for p in one.entry_points),
        )
        for one in found
    )


def test_all_distributions_of_this_environment_are_read_alike():
    assert ours(installed()) == theirs(list(metadata.distributions()))


@pytest.mark.parametrize("name", ["a-pkg", "A_Pkg", "a.pkg", "egg_pkg", "absent", "a", ""])
def test_names_are_compared_as_pip_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str):
    for folder in ("a_pkg-1.0.dist-info", "Egg.Pkg.egg-info"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "METADATA").write_text(f"Name: {folder}\n")
        (tmp_path / folder / "entry_points.txt").write_text(POINTS)
    monkeypatch.setattr(sys, "path", [str(tmp_path), str(tmp_path / "nowhere")])
    wanted = [] if name == "" else list(metadata.distributions(name=name))
    assert ours(installed(name)) == theirs(wanted)


def test_what_python_ignores_is_ignored_and_damage_too(tmp_path: Path, monkeypatch):
    (tmp_path / "a-1.0.dist-info").mkdir()
    (tmp_path / "a-1.0.dist-info/direct_url.json").write_bytes(b"\xff")
    monkeypatch.setattr(sys, "path", [tmp_path, str(tmp_path).encode(), None, str(tmp_path)])
    (found,) = installed("a")
    assert (found.folder, found.read_text("direct_url.json")) == (str(tmp_path), None)


def test_folders_are_listed_once_for_many_packages(tmp_path: Path, monkeypatch):
    (tmp_path / "a-1.0.dist-info").mkdir()
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    with reading_once():
        assert [len(installed(name)) for name in ("a", "b", None)] == [1, 0, 1]
        (tmp_path / "b-1.0.dist-info").mkdir()
        assert [len(installed(name)) for name in ("a", "b", None)] == [1, 0, 1]


def test_nothing_is_kept_when_the_last_of_several_threads_has_read():
    first, second = reading_once(), reading_once()
    first.__enter__()
    second.__enter__()
    assert [once("a", lambda: 1), once("a", lambda: 2)] == [1, 1]
    first.__exit__(None, None, None)
    assert is_reading_once() and once("a", lambda: 3) == 1
    second.__exit__(None, None, None)
    assert not is_reading_once() and once("a", lambda: 4) == 4


def test_a_distribution_in_an_archive_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    with zipfile.ZipFile(tmp_path / "one.zip", "w") as archive:
        archive.writestr("zipped-1.0.dist-info/METADATA", "Name: zipped\n")
        archive.writestr("zipped-1.0.dist-info/entry_points.txt", POINTS)
    monkeypatch.setattr(sys, "path", [str(tmp_path / "one.zip"), str(tmp_path)])
    (found,) = installed("zipped")
    assert ([point.name for point in found.points], found.read_text("none")) == (
        ["talk", "listen", "odd.name"],
        None,
    )
