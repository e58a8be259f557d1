"""The launcher runs the copy of the fleet that `python -m benchmarks mutants` has changed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.mutants.runs import copy_fleet, environment_of


@pytest.mark.thorough
def test_the_nodes_are_those_of_the_copy(tmp_path: Path):
    fleet = tmp_path / "fleet"
    copy_fleet(fleet)
    changed = "raise SystemExit('this is the copy')\n"
    (fleet / "group_gp1" / "nodes" / "dispatcher_node.py").write_text(changed)

    done = subprocess.run(
        [sys.executable, "-m", "launcher", "run", "group_gp1", "dispatcher"],
        cwd=fleet,
        env=environment_of(fleet, tmp_path / "log"),
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )

    assert (done.returncode, "this is the copy" in done.stderr) == (1, True), done
