"""Kinds of expectations about ROS, met and not met by a real node."""

from __future__ import annotations

import signal
from pathlib import Path

import psutil
import pytest

from tests.smoke.bench import Bench

REPOSITORY = Path(__file__).resolve().parents[2]


def talking(name: str = "talker") -> str:
    command = f'[sys.executable, "-m", "tests.smoke.talking_node", "{name}"]'
    return f'ExecuteProcess(cmd={command}, name="{name}", cwd="{REPOSITORY}", output="screen"),'


EXPECTATIONS = """
    for: 10 s
    scenario:
      - {after: ready, do: 'publish /orders std_msgs/msg/String {data: go on}', name: order}
      - {after: ready, do: set /talker speed 2.5, name: faster}
      - {after: faster, do: 'call /switch std_srvs/srv/SetBool {data: true}', name: switched}
    expect:
      - {name: good node, node: /talker}
      - {name: bad node, node: /talker, absent: true, within: 0.1 s, after: ready}
      - {name: good absence, node: /nobody, absent: true}
      - {name: bad absence, node: /talker, absent: true}
      - {name: good topic, topic: /steady, type: std_msgs/msg/String, publishers: 1}
      - {name: bad type, topic: /steady, type: std_msgs/msg/Int32, after: ready}
      - {name: bad count, topic: /steady, publishers: 2, after: ready, within: 3 s}
      - {name: good qos, qos: /drifting, publishers: {reliability: best_effort}}
      - {name: bad qos, qos: /drifting, publishers: {reliability: reliable}, after: ready}
      - {name: good mismatch, qos: /drifting, compatible: false}
      - {name: bad match, qos: /drifting, compatible: true, after: ready, within: 2 s}
      - {name: good rate, rate: /steady, is: 20 Hz ± 3 %}
      - {name: bad rate, rate: /drifting, is: 20 Hz ± 3 %}
      - {name: good drift, rate: /drifting, is: 18.87 Hz ± 3 %}
      - {name: good message, message: /steady, where: json.count > 20, within: 9 s}
      - {name: bad message, message: /steady, where: json.count < 0}
      - {name: good fields, message: /steady, fields: {speed: 2.5}, after: faster, within: 2 s}
      - {name: bad fields, message: /steady, fields: {speed: {min: 3}}}
      - {name: good order, message: /steady, fields: {switched: true}, after: switched}
      - {name: good every, message: /steady, all: true, where: json.count > 0}
      - {name: bad every, message: /steady, all: true, where: json.speed < 2}
      - {name: bad reliable, message: /drifting, qos: {reliability: reliable}}
      - {name: good log, log: 'ordered: go on', level: WARN, process: talker, after: ready}
      - {name: good parameter, parameter: speed, node: /talker, is: 2.5}
      - {name: bad parameter, parameter: speed, node: /talker, is: 9, after: ready, within: 3 s}
      - {name: good service, service: /switch, request: {data: true}, fields: {success: true}}
      - {name: bad service, service: /swich, after: ready, within: 3 s}
      - {name: bad spelling, parameter: sped, node: /talker, is: 9, after: ready, within: 3 s}
      - {name: good once, service: /switch, once: true, request: {data: true}, where: m.success}
      - {name: good memory, shared_memory: clean}
      - {name: good shutdown, clean_shutdown: 5 s}
"""


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """One run for all of them."""
    bench = Bench(tmp_path_factory.mktemp("ros"))
    bench.write(talking())
    bench.expect(EXPECTATIONS)
    done = bench.smoke()
    assert done.returncode == 3, done.stdout + done.stderr
    return bench


NAMES = [line.partition("name: ")[2].partition(",")[0] for line in EXPECTATIONS.splitlines()]


@pytest.mark.parametrize("name", [n for n in NAMES if n.startswith(("good", "bad"))])
def test_a_kind_is_met_or_not(judged: Bench, name: str):
    wanted = "violated" if name.startswith("bad") else "met"
    assert judged.judged(name)["outcome"] == wanted, judged.judged(name)


@pytest.mark.parametrize(
    ("name", "guess"),
    [
        ("bad type", "the topic has another type: /talker uses std_msgs/msg/String"),
        ("bad qos", "reliability is BEST_EFFORT, but RELIABLE is asked for"),
        ("bad reliable", "BEST_EFFORT"),
        ("bad service", "did you mean '/switch'?"),
        ("bad spelling", "did you mean 'speed'?"),
    ],
)
def test_a_failure_guesses_why(judged: Bench, name: str, guess: str):
    assert guess in judged.judged(name)["guess"]


def test_the_graph_is_among_the_evidence(judged: Bench):
    assert '"/talker"' in (judged.evidence / "graph.json").read_text("utf-8")
    assert "/steady" in (judged.evidence / "graph.svg").read_text("utf-8")


def test_two_runs_do_not_see_each_other(tmp_path: Path):
    benches = [Bench(tmp_path / name) for name in ("one", "two")]
    for bench, other in zip(benches, reversed(benches), strict=True):
        bench.folder.mkdir()
        bench.write(talking(bench.folder.name))
        bench.expect(
            f"""
            for: 5 s
            expect:
              - {{name: own, node: /{bench.folder.name}}}
              - {{name: other, node: /{other.folder.name}, absent: true}}
              - {{name: steady, topic: /steady, publishers: 1}}
            """
        )
    runs = [bench.start() for bench in benches]
    told = [run.communicate(timeout=120)[0] for run in runs]
    assert [run.returncode for run in runs] == [0, 0], told


def test_a_killed_node_leaves_nothing_in_shared_memory(tmp_path: Path):
    bench = Bench(tmp_path)
    bench.write(talking())
    bench.expect(
        """
        # The launcher looks once a second what a process has in shared memory.
        scenario: [{after: ready, at: 2 s, do: kill talker, name: kill}]
        expect:
          - {name: there, node: /talker}
          - {name: gone, node: /talker, absent: true, after: kill, within: 5 s}
          - {name: clean, shared_memory: clean}
        """
    )
    done = bench.smoke()
    assert done.returncode == 0, done.stdout


def test_a_run_whose_probe_hangs_ends_and_tells(tmp_path: Path):
    bench = Bench(tmp_path)
    bench.write(talking())
    run = bench.start("--expect-node=/talker", "--for=5")
    assert run.stdout is not None
    told = ""
    while "ready" not in told:
        told = run.stdout.readline()
    (probe,) = [
        p for p in psutil.Process(run.pid).children() if "launcher.graph.probe" in p.cmdline()
    ]
    probe.suspend()
    told, _ = run.communicate(timeout=120)
    assert run.returncode == 1
    assert "the ROS probe did not answer" in told
    assert not probe.is_running()


def test_the_graph_is_drawn_even_if_nothing_of_it_is_expected(tmp_path: Path):
    bench = Bench(tmp_path)
    bench.launch_file = REPOSITORY / "launch" / "system.launch.py"
    done = bench.smoke(
        "--no-file", "--for=4", "--expect-log=monitor: Fleet report", "--clean-shared-memory"
    )
    assert done.returncode == 0, done.stdout
    assert '"/monitor"' in (bench.evidence / "graph.json").read_text("utf-8")
    assert "/fleet/status" in (bench.evidence / "graph.svg").read_text("utf-8")


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
    assert "/steady" in (bench.evidence / "graph.svg").read_text("utf-8")
