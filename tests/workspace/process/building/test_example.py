"""The example workspace: built, launched and tested as a user would."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.packages import source_packages
from tests.support.repository import REPOSITORY
from tests.support.workspaces import EXAMPLE, BuiltWorkspace, example, launcher

PACKAGES = ["fleet_interfaces", "fleet_nodes"]
EXPECTATIONS = EXAMPLE / "src/fleet_nodes/launch/fleet.expect.yaml"


@pytest.fixture(params=["system", pytest.param("zig", marks=pytest.mark.thorough)])
def workspace(request: pytest.FixtureRequest) -> BuiltWorkspace:
    """The example, built by the system's compiler and by zig."""
    return example(request.getfixturevalue("tmp_path_factory").getbasetemp(), request.param)


def colcon_list(folder: Path) -> list[str]:
    colcon = Path(sys.executable).with_name("colcon")
    done = subprocess.run(
        [colcon, "list", "--names-only"], cwd=folder, capture_output=True, text=True, check=True
    )
    return sorted(done.stdout.split())


@pytest.mark.thorough
def test_it_meets_its_expectations(workspace: BuiltWorkspace, tmp_path: Path):
    """With other time limits: those of the file are for a machine that does nothing else."""
    text, limits = re.subn(
        r"\b(within|clean_shutdown): \d+ s", r"\1: 60 s", EXPECTATIONS.read_text("utf-8")
    )
    assert limits == 2
    file = tmp_path / EXPECTATIONS.name
    file.write_text(text, encoding="utf-8")
    patience = ("--ready-within=60", "sigterm_timeout:=60")
    words = ("fleet_nodes", "fleet.launch.py", *patience, f"--expect={file}")
    done = launcher(workspace.root, "smoke", *words)
    assert done.code == 0, done.out


@pytest.mark.thorough
def test_its_tests_pass_and_its_nodes_stop_in_order(fleet_workspace: BuiltWorkspace):
    done = launcher(fleet_workspace.root, "test", "fleet_nodes")

    assert (done.code, done.lines[-1]) == (0, "1 package: 5 passed"), done
    for sign in ("is invalid", "never awaited", "never retrieved", "[ERROR]", "Traceback"):
        assert sign not in done.out + done.err


@pytest.mark.thorough
def test_colcon_finds_the_packages_of_the_example_in_the_example_only(tmp_path: Path):
    assert colcon_list(EXAMPLE) == PACKAGES
    assert colcon_list(REPOSITORY) == ["group_gp1"]
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "checkout").symlink_to(REPOSITORY)
    assert colcon_list(tmp_path) == ["group_gp1"]


def test_the_checkout_does_not_use_the_example_from_its_source(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(REPOSITORY)
    assert not [folder for _, folder in source_packages.around() if folder.startswith(f"{EXAMPLE}")]
    monkeypatch.chdir(EXAMPLE)
    here = {name for name, folder in source_packages.around() if folder.startswith(f"{EXAMPLE}")}
    assert here == {*PACKAGES}
