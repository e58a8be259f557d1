"""What is read of installed distributions, compared with `importlib.metadata`."""

from __future__ import annotations

import os
import sys
import zipfile
from importlib import metadata
from pathlib import Path

import pytest

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
