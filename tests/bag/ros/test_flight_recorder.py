"""`--record`: the last seconds of a run, written when a process dies, and on request."""

from __future__ import annotations

import json
import re
import signal
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.bag import check
from launcher.bag.reader import Bag
from tests.support.benches import HEAD
from tests.support.children import children_with
from tests.support.controlled_run import ControlledRun
from tests.support.json_forms import fit
from tests.support.ros_domain import ros_domain
from tests.support.verbs import launcher
from tests.support.waiting import wait_until

# Two talkers on the same topic, so that the index has to tell them apart.
TALKER = """
import sys, time, rclpy
from std_msgs.msg import String
rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
node = rclpy.create_node(sys.argv[1])
publisher = node.create_publisher(String, "/talk", 10)
number = 0
while True:
    publisher.publish(String(data=f"{sys.argv[1]} {number} " + "x" * int(sys.argv[2])))
    number += 1
    time.sleep(0.02)
"""


class Run:
    """A run of the talkers `left` and `right` with the flight recorder."""

    def __init__(self, tmp_path: Path, env: dict[str, str], *words: str, size: int = 10) -> None:
        program = tmp_path / "talker.py"
        program.write_text(TALKER)
        file = tmp_path / "talk.launch.py"
        command = f"exec {sys.executable} {program}"
        nodes = ", ".join(
            f'sh("{command} {name} {size}", name="{name}")' for name in ("left", "right")
        )
        file.write_text(f"{HEAD}{nodes}\n    ])\n")
        self.env = {**env, "ROS_LOG_DIR": str(tmp_path / "log")}
        self.control = ControlledRun(
            [sys.executable, "-m", "launcher", str(file), "--no-console", *words],
            env=self.env,
            runtime=Path(env["XDG_RUNTIME_DIR"]),
            screen=tmp_path / "screen",
        )

    @property
    def folder(self) -> Path:
        return Path(self.env["ROS_LOG_DIR"]) / "latest"

    @property
    def screen(self) -> str:
        return self.control.screen_path.read_text()

    def snapshots(self) -> list[Path]:
        found = self.folder.glob("snapshots/*")
        return sorted(path for path in found if path.suffix != ".part")

    def wait_until_recording(self) -> None:
        """Until the recorder has received something of both talkers."""

        def has_both() -> bool:
            answer = self.verb("snapshot", "--json", "to see whether it has begun")
            if answer.code != 0:
                return False
            (found,) = fit("snapshot", answer.out)
            index = (Path(found["path"]) / "index.txt").read_text()
            return all(f"last /talk of {name}" in index for name in ("left", "right"))

        wait_until(has_both, "a message of both talkers")

    def verb(self, *words: str):
        return launcher(self.control.env, *words)


@pytest.fixture
def domain(tmp_path: Path) -> Iterator[dict[str, str]]:
    with tempfile.TemporaryDirectory(prefix="run-") as runtime, ros_domain(tmp_path) as env:
        yield {**env, "TMPDIR": runtime, "XDG_RUNTIME_DIR": runtime}


def texts(bag: Path, topic: str = "/talk") -> list[str]:
    return [one.data[8:].rstrip(b"\0").decode() for one in Bag(str(bag)).messages([topic])]


def deaths(run: Run) -> list[Path]:
    return [path for path in run.snapshots() if path.name.endswith("-death")]


def test_a_death_is_recorded_with_what_came_before(tmp_path: Path, domain):
    run = Run(tmp_path, domain, "--record")
    with run.control:
        run.wait_until_recording()
        run.verb("kill", "left", "-9", "--as-crash")
        wait_until(lambda: deaths(run), "a snapshot")
        folder = deaths(run)[0]
        index = (folder / "index.txt").read_text()
        assert run.verb("quit").code == 0
    assert index.startswith("why: left-1 died (SIGKILL)\n"), index
    times = {
        text: float(seconds)
        for seconds, text in re.findall(r"^ +([\d.]+)  (.+)$", index, re.MULTILINE)
    }
    assert times["left-1: ended (SIGKILL)"] >= 1.0  # what followed is there, too
    assert times["last /talk of right"] < times["left-1: ended (SIGKILL)"]
    assert times["last /talk of right"] < times["last /talk of left"]
    found = texts(folder / "bag")
    assert {text.split()[0] for text in found} == {"left", "right"}
    numbers = [int(text.split()[1]) for text in found if text.startswith("right")]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert check.check(str(folder / "bag")).is_whole
    events = [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]
    assert any(one["event"] == "ended" and one["process"] == "left-1" for one in events)
    assert (folder / "plan.json").exists()
    assert "process started" in (folder / "logs" / "launch.log").read_text()
    assert f"/snapshots/{folder.name}: left-1 died (SIGKILL)" in run.screen


@pytest.mark.thorough
def test_what_is_kept_is_bounded(tmp_path: Path, domain):
    run = Run(tmp_path, domain, "--record", "--record-keep", "60s,1M", size=20_000)
    with run.control:
        run.wait_until_recording()
        wait_until(
            lambda: "since memory was full" in _index(run.verb("snapshot", "full").out),
            "a full ring",
        )
        run.verb("quit")
    for folder in run.snapshots():
        size = sum(len(one.data) for one in Bag(str(folder / "bag")).messages())
        assert size <= 1024**2


def _index(answer: str) -> str:
    return (Path(answer.removeprefix("snapshot in ").strip()) / "index.txt").read_text()


def test_a_killed_launcher_leaves_a_snapshot(tmp_path: Path, domain):
    run = Run(tmp_path, domain, "--record")
    with run.control:
        run.wait_until_recording()
        run.control.process.send_signal(signal.SIGKILL)
        run.control.process.wait()
        wait_until(lambda: deaths(run), "a snapshot")
    index = (deaths(run)[0] / "index.txt").read_text()
    assert index.startswith("why: the launcher was killed\n")


@pytest.mark.thorough
def test_everything_is_written_with_all(tmp_path: Path, domain):
    run = Run(tmp_path, domain, "--record=all", "--record-topics", "^/talk$")
    with run.control:
        run.wait_until_recording()
        run.verb("quit")
        run.control.process.wait(timeout=60)
    bag = Bag(str(run.folder / "bag"))
    assert [topic.name for topic in bag.topics] == ["/talk"]
    assert bag.notes == []
    numbers = [int(text.split()[1]) for text in texts(run.folder / "bag") if "left" in text]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert len(numbers) > 3


@pytest.mark.thorough
def test_a_recorder_that_is_killed_is_started_again(tmp_path: Path, domain):
    run = Run(tmp_path, domain, "--record")
    with run.control:
        run.wait_until_recording()
        (recorder,) = children_with(run.control.process.pid, "launcher.bag.ros.flight")
        recorder.suspend()
        with run.control.connect() as connection:
            connection.send("snapshot")
            connection.ask("ps")  # so the launcher has got the request
            recorder.kill()
            answer = connection.read(60)
        assert answer["error"]["message"] == "no snapshot: the flight recorder died"
        wait_until(lambda: "the flight recorder died (signal 9)" in run.screen, "a warning")
        run.wait_until_recording()
        assert run.verb("quit").code == 0
        assert run.control.process.wait(timeout=60) == 0


@pytest.mark.thorough
def test_a_run_without_it_says_so(tmp_path: Path, domain):
    run = Run(tmp_path, domain)
    with run.control:
        wait_until(lambda: "right" in run.verb("ps").out, "the run")
        answer = run.verb("snapshot")
        run.verb("quit")
    assert answer.code == 1
    assert answer.err == ("error: this run is not recorded\nhint: start the run with --record\n")


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--record=some"], "--record: 'some' is not 'all'"),
        (["--record-keep", "5s"], "--record-keep and --record-topics need --record"),
        (["--record", "--record-keep", "5"], "'5' is neither a time such as 60s nor a size"),
        (["--record", "--record-topics", "["], "'[' is not a regular expression"),
        (["--record", "--no-log-files"], "--record and --no-log-files exclude each other"),
        (["--record", "--no-control"], "--record and --no-control exclude each other"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_mistakes(tmp_path: Path, domain, words: list[str], text: str):
    answer = launcher(domain, "system", *words)
    assert answer.code == 2
    assert text in answer.err
