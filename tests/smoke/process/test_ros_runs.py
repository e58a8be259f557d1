"""Whole smoke runs of a real node."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from tests.smoke.process.bench import PATIENT, Bench, talking
from tests.support.children import children_with
from tests.support.drawing import is_drawn
from tests.support.repository import REPOSITORY
from tests.support.waiting import rest_of

pytestmark = pytest.mark.thorough


def test_two_runs_do_not_see_each_other(tmp_path: Path):
    benches = [Bench(tmp_path / name) for name in ("one", "two")]
    for bench, other in zip(benches, reversed(benches), strict=True):
        bench.folder.mkdir()
        bench.write(talking(bench.folder.name))
        bench.expect(
            f"""
            for: 5 s
            expect:
              - {{name: own, node: /{bench.folder.name}, within: 60 s}}
              - {{name: other, node: /{other.folder.name}, absent: true}}
              - {{name: steady, topic: /steady, publishers: 1, within: 60 s}}
            """
        )
    runs = [bench.start() for bench in benches]
    told = [run.communicate(timeout=120)[0] for run in runs]
    assert [run.returncode for run in runs] == [0, 0], told


def test_a_killed_node_leaves_nothing_in_shared_memory(tmp_path: Path):
    bench = Bench(tmp_path)
    bench.write(talking(), PATIENT)  # without it the run ends at once, perhaps before a look
    bench.expect(
        """
        # The launcher looks once a second what a process has in shared memory.
        scenario: [{after: ready, at: 10 s, do: kill talker, name: kill}]
        expect:
          - {name: there, node: /talker, within: 60 s}
          - {name: gone, node: /talker, absent: true, after: kill, within: 60 s}
          - {name: clean, shared_memory: clean}
        """
    )
    done = bench.smoke()
    assert done.returncode == 0, done.stdout


def test_a_run_whose_probe_hangs_ends_and_tells(tmp_path: Path):
    bench = Bench(tmp_path)
    bench.write(talking())
    run = bench.start("--expect-node=/talker=60s", "--for=5")
    assert run.stdout is not None
    told = ""
    while "ready" not in told:
        told = run.stdout.readline()
    (probe,) = children_with(run.pid, "launcher.ros.probe")
    probe.suspend()
    told, _ = rest_of(run, 120)
    assert run.returncode == 1
    assert "the ROS probe did not answer" in told
    assert not probe.is_running()


def test_the_graph_is_drawn_even_if_nothing_of_it_is_expected(tmp_path: Path):
    bench = Bench(tmp_path)
    bench.launch_file = REPOSITORY / "launch" / "system.launch.py"
    bench.expect("{expect: [{log: Fleet report, process: monitor, within: 60 s}]}")
    file = bench.folder / "tested.expect.yaml"
    done = bench.smoke(f"--expect={file}", "--expect-shared-memory")
    assert done.returncode == 0, done.stdout
    assert '"/monitor"' in (bench.evidence / "graph.json").read_text("utf-8")
    assert is_drawn(bench.evidence / "graph.svg", "/fleet/status")


def test_the_graph_is_drawn_of_a_run_that_is_interrupted(tmp_path: Path):
    bench = Bench(tmp_path)
    bench.write(talking())
    run = bench.start("--for=60", "--expect-log=talking")
    assert run.stdout is not None
    told = ""
    while "log talking" not in told:
        told = run.stdout.readline()
    run.send_signal(signal.SIGINT)
    run.communicate(timeout=120)
    assert run.returncode == 130
    assert '"/talker"' in (bench.evidence / "graph.json").read_text("utf-8")
    assert is_drawn(bench.evidence / "graph.svg", "/steady")
