"""A watched run with the real watcher, from the first look to its incident."""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path

import pytest

from launcher.faults.history.reading import histories
from launcher.faults.history.versions import hash_of
from tests.support.benches import HEAD
from tests.support.controlled_run import ControlledRun
from tests.support.ros_domain import ros_domain
from tests.support.verbs import launcher
from tests.support.waiting import wait_until

EXPECTED = """
expect:
  - {log: the robot is lost, count: 0, name: not lost}
  - clean_shutdown: 30 s
"""


@pytest.mark.thorough
def test_a_fault_is_recorded_written_down_and_remembered(tmp_path: Path):
    sign, included = tmp_path / "sign", tmp_path / "included.launch.xml"
    script = f'while sleep 0.5; do [ ! -e {sign} ] || echo "the robot is lost"; done'
    file = tmp_path / "watched.launch.py"
    include = f'__import__("launch").actions.IncludeLaunchDescription("{included}")'
    file.write_text(f"{HEAD}{include}, sh({script!r}, name='robot')\n    ])\n")
    included.write_text("<launch/>")
    (tmp_path / "watched.expect.yaml").write_text(EXPECTED)
    words = [sys.executable, "-m", "launcher", str(file), "--watchful", "--record", "--no-console"]
    with tempfile.TemporaryDirectory(prefix="run-") as runtime, ros_domain(tmp_path / "log") as env:
        run = ControlledRun(words, env=env, runtime=Path(runtime), screen=tmp_path / "screen")
        with run:
            run.wait_for("watching: 1 expectation of watched.expect.yaml and ")
            run.ask("faults", mute="disk")
            assert [one["fault"] for one in run.ask("faults")["mutes"]] == ["disk"]
            wait_until(lambda: launcher(run.env, "snapshot", "x").code == 0, "the recorder")
            sign.touch()
            folder = (tmp_path / "log" / "latest").resolve()
            document = folder / "incidents" / "1.json"
            wait_until(document.exists, "an incident")
            wait_until(lambda: json.loads(document.read_text())["snapshot"], "its snapshot")
            run.ask("quit")
            run.exit_code()

    (snapshot,) = folder.glob("snapshots/*-fault")
    assert "fault 'not lost'" in (snapshot / "index.txt").read_text()
    incident = json.loads(document.read_text())
    assert [one["fault"] for one in incident["faults"]] == ["not lost"]
    assert incident["snapshot"] == str(snapshot)
    files_hash = incident["versions"]["hash"]
    assert files_hash is not None and files_hash != hash_of([str(file)])
    (target,) = histories(str(folder.parent))
    assert [one.fault for one in target.faults] == ["not lost"]
    assert target.faults[0].first_version.files_hash == files_hash
