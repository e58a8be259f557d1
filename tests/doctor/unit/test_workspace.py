"""What the doctor says about a workspace, with the command that repairs it."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from launcher.base.model.level import Level
from launcher.doctor import stale_workspace
from launcher.doctor.doctor_facts import WorkspaceFacts
from launcher.doctor.workspace_checks import check_workspace
from launcher.packages.workspace import Workspace
from launcher.workspace.building import records, sources
from launcher.workspace.building.build_place import Place
from tests.workspace.unit.building.source_tree import python_package, write

ROOT = "/my ws"


def facts(**changed: Any) -> WorkspaceFacts:
    return WorkspaceFacts(root=ROOT, build="launcher build", **changed)


def test_nothing_is_wrong():
    (found,) = check_workspace(facts())
    assert (found.level, found.text) == (Level.OK, "/my ws: everything is built")


@pytest.mark.parametrize(
    ("changed", "level", "text", "advice"),
    [
        (
            {"error": "/a.dsv:1: wrong"},
            Level.PROBLEM,
            "/a.dsv:1: wrong",
            "build again: launcher build",
        ),
        (
            {"changed": {"b": "not built", "a": "a.msg changed"}},
            Level.NOTE,
            "must be built: a (a.msg changed), b (not built)",
            "launcher build",
        ),
        (
            {"changed": dict.fromkeys("abcdefg", "new")},
            Level.NOTE,
            "must be built: a (new), b (new), c (new), d (new), e (new) and 2 more",
            "launcher build",
        ),
        (
            {"other_python": {"a": "3.12"}},
            Level.PROBLEM,
            "built for another Python: a (Python 3.12)",
            "rm -r '/my ws'/build/a '/my ws'/install/a && launcher build",
        ),
        (
            {"no_interpreter": {"a": "/gone/python"}},
            Level.PROBLEM,
            "programs whose interpreter does not exist any more: a (/gone/python)",
            "rm -r '/my ws'/build/a '/my ws'/install/a && launcher build",
        ),
        (
            {"other_python": {"a": "3.12"}, "cleaned": ("a",), "changed": {"a": "other tools"}},
            Level.PROBLEM,
            "built for another Python: a (Python 3.12)",
            "launcher build",
        ),
        (
            {"moved_from": "/first", "cleaned": ("a",), "changed": {"a": "moved"}},
            Level.PROBLEM,
            "it was built in /first, and moved or copied from there: the links in install/ still "
            "lead there",
            "launcher build",
        ),
        (
            {"moved_from": "/first"},
            Level.PROBLEM,
            "it was built in /first, and moved or copied from there: the links in install/ still "
            "lead there",
            "rm -r '/my ws'/build '/my ws'/install && launcher build",
        ),
        (
            {"broken": {"a": "/my ws/build/a"}, "changed": {"a": "not built"}},
            Level.PROBLEM,
            "installed as links into folders that are gone: a (/my ws/build/a)",
            "launcher build",
        ),
        (
            {"gone": ("a",), "dead": ("a",)},
            Level.PROBLEM,
            "installed as links to sources that are gone from src/: a",
            "put the sources back, or: rm -r '/my ws'/build/a '/my ws'/install/a",
        ),
        (
            {"gone": ("a",)},
            Level.NOTE,
            "installed, but no source in src/: a",
            "rm -r '/my ws'/build/a '/my ws'/install/a",
        ),
        (
            {"twice": {"a": ("/x", "/y y")}},
            Level.PROBLEM,
            "two packages are named a: /x and /y y",
            "remove one, or: touch '/y y/COLCON_IGNORE'",
        ),
        (
            {"hides": {"std_msgs": "/venv"}},
            Level.NOTE,
            "packages that replace those of the environment: std_msgs (/venv)",
            "if that is not intended, remove them from src/, then from install/ and build/",
        ),
        (
            {"missing_underlays": ("/low",)},
            Level.PROBLEM,
            "it was built on /low, which does not exist any more",
            "put it back; or remove what needs it from src/, then launcher build",
        ),
        (
            {"scripts": ("/s.sh",)},
            Level.NOTE,
            "/s.sh is not run: it has no .dsv file with its variables",
            ". '/my ws/install/setup.sh'",
        ),
    ],
)
def test_each_finding_names_its_repair(changed, level: Level, text: str, advice: str):
    (found,) = check_workspace(facts(**changed))
    assert (found.level, found.text, found.advice) == (level, text, advice)


def test_a_shared_prefix_is_built_afresh_as_a_whole():
    (found,) = check_workspace(facts(gone=("a",), is_merged=True))
    assert found.advice == "rm -r '/my ws'/build '/my ws'/install && launcher build"


def test_a_build_by_another_environment_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    write(tmp_path / "src", python_package("p"))
    (package,) = sources.find([str(tmp_path / "src")]).packages
    index = "install/p/share/colcon-core/packages/p"
    write(tmp_path, {"install/.colcon_install_layout": "isolated\n", index: "", "build/p/x": ""})
    place = Place(str(tmp_path), package.folder)
    version = f"{sys.version_info.major}.{sys.version_info.minor}.2"
    monkeypatch.setattr(stale_workspace.tools, "fingerprint", lambda: f"{version} /my envs/b 34cd")

    def after(tools: str, *prefixes: str) -> WorkspaceFacts:
        setting = records.BuildSetting(place, True, tools, "", (), prefixes or (sys.prefix,))
        records.complete(place, records.make(package, setting, {}, None))
        return stale_workspace.inspect(Workspace(str(tmp_path), place.install), {})

    assert after(f"{version} /my envs/a 12ab").changed == {
        "p": f"built with Python {version} of /my envs/a"
    }
    updated = after(f"{version} /my envs/b 12ab")
    assert updated.changed == {"p": "wheels were updated, installed or removed since it was built"}
    on_other = after(f"{version} /my envs/b 34cd", "/low/p", "/low", sys.prefix)
    assert on_other.changed == {"p": "built on /low, which is gone"}
    on_less = after(f"{version} /my envs/b 34cd", "/usr")
    assert on_less.changed == {"p": "built on /usr, which is not in use now"}
    assert on_less.other_python == {}
    assert after("3.4.1 /my envs/b 34cd").other_python == {"p": "3.4"}
