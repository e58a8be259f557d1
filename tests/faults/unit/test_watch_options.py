"""Which expectations a watched run has."""

from __future__ import annotations

from pathlib import Path

from launcher.base.model.run_options import RunOptions
from launcher.faults.watch_options import with_expectations_beside


def test_the_file_beside_the_launch_file_is_used_unless_one_is_given(tmp_path: Path):
    launch_file, beside = tmp_path / "a.launch.py", tmp_path / "a.expect.yaml"
    options = RunOptions(watchful=True)
    assert with_expectations_beside(options, str(launch_file)) == options

    beside.write_text("expect: [{no_errors: '*'}]\n", encoding="utf-8")
    assert with_expectations_beside(options, str(launch_file)).expect == str(beside)
    given = RunOptions(watchful=True, expect="other.yaml")
    assert with_expectations_beside(given, str(launch_file)) == given
