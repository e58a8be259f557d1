"""Which packages `hosts sync` finds, and that they run from what was brought."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from launcher.base.errors import LauncherError, UsageError
from launcher.hosts.sync.synced_packages import Brought, collect
from launcher.packages.workspace import workspace_at
from tests.support.environments import environment_with_ros
from tests.support.own_package import write_package
from tests.support.repository import REPOSITORY
from tests.support.sync_hosts import Site
from tests.support.workspaces import BuiltWorkspace

LAUNCHER = ("-m", "launcher")


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The source folder of a package, in which the operator works."""
    folder = write_package(tmp_path, "own")
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def site(tmp_path: Path) -> Site:
    return Site(tmp_path / "bot")


def paths(brought: Brought) -> set[str]:
    return {*brought.tree.entries}


@pytest.mark.thorough
def test_a_package_runs_that_is_used_from_its_source_folder(own: Path, site: Site):
    (own / ".env").write_text("TOKEN=1")
    (own / "own/__pycache__").mkdir(exist_ok=True)
    (own / "own/__pycache__/talker.cpython-311.pyc").write_text("")

    found = collect(None)
    site.sync(found)
    own.rename(own.with_name("elsewhere"))

    assert "own" in found.packages
    assert not [path for path in paths(found) if ".env" in path or "__pycache__" in path]
    answer = site.run(*LAUNCHER, "run", "own", "own_talker", "a")
    assert answer == "node: there is p.yaml: True ['a']\n"


@pytest.mark.thorough
@pytest.mark.parametrize("is_legacy", [False, True], ids=["now", "before pip 23.1"])
def test_a_package_that_pip_has_installed_from_a_folder_runs(
    own: Path, tmp_path: Path, is_legacy: bool
):
    env = environment_with_ros(tmp_path / "venv")
    words = ("--no-deps", "--no-build-isolation", "--quiet", "--disable-pip-version-check")
    env.pip("install", *words, str(own))
    if is_legacy:
        to_legacy_installation(env.prefix)
    bring = (
        "from pathlib import Path; from launcher.hosts.sync.synced_packages import collect\n"
        "from tests.support.sync_hosts import Site\n"
        f"site = Site(Path({str(tmp_path / 'far/bot')!r}), python={sys.executable!r})\n"
        "site.sync(collect(None))\n"
    )
    outside = tmp_path / "outside"
    outside.mkdir()
    env.run("-c", bring, cwd=outside, PYTHONPATH=str(REPOSITORY))
    far = Site(tmp_path / "near")
    far.home = tmp_path / "far/bot"

    assert far.run(*LAUNCHER, "run", "own", "own_talker").startswith("node: there is p.yaml: True")


def to_legacy_installation(prefix: Path) -> None:
    """What pip before 23.1 leaves of `own` where there is no `wheel`: setup.py has installed it."""
    (site,) = prefix.glob("lib/python*/site-packages")
    if not (found := [*site.glob("own-*.dist-info")]):
        return  # such a pip has installed it
    (info,) = found
    lines = (info / "RECORD").read_text().splitlines()
    files = [line.split(",")[0] for line in lines if not line.startswith(info.name)]
    for name in ("RECORD", "WHEEL", "INSTALLER", "direct_url.json"):
        (info / name).unlink()
    (info / "METADATA").rename(info / "PKG-INFO")
    own = [path.name for path in info.iterdir() if path.is_file()]
    text = "".join(f"{line}\n" for line in [*(f"../{file}" for file in files), *own])
    (info / "installed-files.txt").write_text(text)
    info.rename(info.with_suffix(".egg-info"))


@pytest.mark.thorough
def test_what_is_built_in_a_workspace_runs(fleet_workspace: BuiltWorkspace, site: Site):
    """Compiled types, and nodes that are links to their sources here."""
    found = collect(workspace_at(str(fleet_workspace.root)))

    site.sync(found)

    assert {"fleet_interfaces", "fleet_nodes"} <= {*found.packages}
    shown = site.run(*LAUNCHER, "interface", "show", "fleet_interfaces/msg/RobotStatus")
    assert "TaskAssignment assignment" in shown
    here = str(fleet_workspace.root)
    texts = [
        entry
        for entry in found.tree.entries.values()
        if entry.path.startswith("install/") and entry.path.endswith((".py", ".dsv"))
    ]
    assert texts
    for entry in (*texts, *(one for one in found.tree.entries.values() if one.is_executable)):
        if not entry.path.endswith(".so"):
            assert here not in b"".join(entry.blocks()).decode(errors="replace"), entry.path
    assert not [path for path in paths(found) if "/include/" in path or path.endswith(".c")]
    done = site.run(*LAUNCHER, "plan", "fleet_nodes", "fleet.launch.py")
    assert str(site.current.resolve()) in done


def test_beside_a_package_only_what_it_needs_is_brought(own: Path, tmp_path: Path):
    write_package(tmp_path, "needed")
    write_package(tmp_path, "other")
    manifest = own / "package.xml"
    text = manifest.read_text().replace("<export>", "<depend>needed</depend><export>")
    manifest.write_text(text)

    assert {"own", "needed"} <= {*collect(None).packages}
    assert "other" not in collect(None).packages
    assert "other" in collect(None, ["other"]).packages


def test_an_unknown_package_is_an_error(own: Path):
    with pytest.raises(UsageError, match="--package: 'ownn' is not found") as caught:
        collect(None, ["ownn"])
    assert caught.value.hint == "did you mean 'own'?"


def test_interfaces_that_are_needed_and_not_built_are_told(own: Path, tmp_path: Path):
    folder = tmp_path / "own_interfaces"
    folder.mkdir()
    (folder / "package.xml").write_text("<package><name>own_interfaces</name></package>")
    (folder / "CMakeLists.txt").write_text("project(own_interfaces)")
    manifest = own / "package.xml"
    text = manifest.read_text().replace("<export>", "<depend>own_interfaces</depend><export>")
    manifest.write_text(text)

    left_out = collect(None).tree.left_out

    assert "own_interfaces is not built" in left_out[str(folder)]


def test_a_link_out_of_a_package_is_an_error(own: Path, tmp_path: Path):
    (tmp_path / "secret").write_text("secret")
    (own / "own/key").symlink_to(tmp_path / "secret")

    with pytest.raises(LauncherError, match="leads out of its package"):
        collect(None)


@pytest.mark.thorough
def test_the_launcher_is_brought_whole(own: Path, site: Site):
    site.sync(collect(None))

    assert site.run(*LAUNCHER, "--version").strip()
    there = {
        path.relative_to(site.current.resolve() / "lib").as_posix()
        for path in (site.current.resolve() / "lib").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    here = {
        path.relative_to(REPOSITORY).as_posix()
        for path in (REPOSITORY / "launcher").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert there == here
    assert os.access(site.current / "bin/launcher", os.X_OK)
