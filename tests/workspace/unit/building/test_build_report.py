"""What `launcher build` prints at the end."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.errors import ExitCode
from launcher.workspace.building import build_report
from launcher.workspace.building.build_place import Place
from launcher.workspace.building.builder import BuildOutcome


@pytest.mark.parametrize(("number", "name"), [(9, "SIGKILL"), (40, "signal 40")])
def test_a_signal_that_ended_colcon_is_named(
    number: int, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    outcome = BuildOutcome(Place(str(tmp_path), str(tmp_path / "src")), code=-number)

    assert build_report.show(outcome) is ExitCode.PROCESS_FAILED

    error = f"error: colcon was killed by {name}; the next build continues\n"
    assert capsys.readouterr().err == error
