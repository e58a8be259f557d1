"""`bag record`: what is published is in the bag, byte by byte, whatever happens to the recorder."""

from __future__ import annotations

import contextlib
import os
import re
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

import pexpect
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from launcher.bag import check, metadata
from launcher.bag.reader import Bag
from launcher.packages.distribution import installed
from tests.support.bag_talker import TOPICS
from tests.support.bags import START_NS, counting, write_bag
from tests.support.repository import REPOSITORY
from tests.support.ros_domain import ros_domain, talking
from tests.support.variations import few_of
from tests.support.verbs import TIMEOUT_S, launcher
from tests.support.waiting import rest_of, wait_until


@pytest.fixture
def domain(tmp_path: Path) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path / "log") as env:
        yield env


class Recording:
    """A running `bag record`."""

    def __init__(
        self, env: Mapping[str, str], folder: Path, *words: str, file_limit: int | None = None
    ) -> None:
        def limit() -> None:
            if file_limit is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (file_limit, file_limit))

        self.folder = folder
        self.process = subprocess.Popen(
            [sys.executable, "-m", "launcher", "bag", "record", "-o", str(folder), *words],
            env=dict(env),
            cwd=REPOSITORY,
            stdin=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=limit,
        )
        self.text = ""

    def read_until(self, text: str) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.text += line
            if text in line:
                return
        raise AssertionError(f"no {text!r} in {self.text}")

    def end(self, signum: int = signal.SIGINT) -> int:
        self.process.send_signal(signum)
        return self.wait()

    def wait(self) -> int:
        self.text += rest_of(self.process, TIMEOUT_S)[1]
        return self.process.returncode


@contextlib.contextmanager
def recording(env: Mapping[str, str], folder: Path, *words: str, **more) -> Iterator[Recording]:
    one = Recording(env, folder, *words, **more)
    try:
        yield one
    finally:
        if one.process.poll() is None:
            one.process.kill()
            one.process.communicate()


def publish(talker: subprocess.Popen[str], count: int, period_s: float = 0.002) -> None:
    assert talker.stdin is not None
    assert talker.stdout is not None
    talker.stdin.write(f"{count} {period_s}\n")
    talker.stdin.flush()
    assert "done\n" in iter(talker.stdout.readline, "")


def records(talker: subprocess.Popen[str], folder: Path) -> bool:
    """Whether one more message, or one before it, is in the bag."""
    publish(talker, 1)
    return bool(contents(folder, "/bag/text"))


def decoded(folder: Path, topic: str) -> list[object]:
    """Messages of a type with gaps between its fields, in which CDR may have anything."""
    return [deserialize_message(data, TOPICS[topic][1]) for data in contents(folder, topic)]


def contents(folder: Path, topic: str) -> list[bytes]:
    return [message.data for message in Bag(str(folder)).messages([topic])]


def published(topic: str, count: int, first: int = 0) -> list[bytes]:
    messages = [serialize_message(TOPICS[topic][0](k)) for k in range(first, first + count)]
    return [one + bytes(-len(one) % 4) for one in messages]  # as DDS pads what it sends


def test_everything_is_recorded_as_published_and_others_read_it(domain, tmp_path: Path):
    folder = tmp_path / "bag"
    with (
        talking(domain, "tests.support.bag_talker") as talker,
        recording(domain, folder, "-a") as recorder,
    ):
        publish(talker, 200)
        assert recorder.end() == 0, recorder.text
    lost = [line for line in recorder.text.splitlines() if "not received" in line]
    assert all(line.startswith("  /bag/cloud:") for line in lost), recorder.text
    for topic in ("/bag/text", "/bag/big"):
        assert contents(folder, topic) == published(topic, 200), topic
    assert decoded(folder, "/bag/pose") == [TOPICS["/bag/pose"][0](k) for k in range(200)]
    for cloud in decoded(folder, "/bag/cloud"):  # BEST_EFFORT may be lost, never changed
        assert cloud == TOPICS["/bag/cloud"][0](cloud.width)
    _by_mcap(folder)
    _by_rosbags(folder)
    known = metadata.read(str(folder))
    offered = {topic.name: topic.qos for topic in known.topics}
    assert offered["/bag/pose"][0]["durability"] == "transient_local"
    assert offered["/bag/cloud"][0]["reliability"] == "best_effort"
    assert all(topic.type_hash.startswith("RIHS01_") for topic in known.topics)
    assert {"/rosout", "/parameter_events"} <= offered.keys()


def _by_mcap(folder: Path) -> None:
    """With the decoders made from the schemas of the file."""
    with (folder / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        poses = [
            (one.decoded_message, one.message)
            for one in reader.iter_decoded_messages(topics=["/bag/pose"])
        ]
        texts = [one.decoded_message.data for one in reader.iter_decoded_messages("/bag/text")]
    assert texts == [TOPICS["/bag/text"][0](k).data for k in range(200)]
    for k, (pose, message) in enumerate(poses):
        assert (pose.header.frame_id, pose.pose.position.x) == (f"frame {k}", k * 0.25)
        assert message.publish_time <= message.log_time


def _by_rosbags(folder: Path) -> None:
    """With the definitions of the bag alone, and those that rosbags brings."""
    store = get_typestore(Stores.ROS2_JAZZY)  # a tenth of a second
    with Reader(folder) as reader:
        for connection, _, data in reader.messages():
            if connection.topic not in TOPICS:
                continue
            assert store.hash_rihs01(connection.msgtype) == connection.digest
            theirs = store.deserialize_cdr(data, connection.msgtype)
            ours = deserialize_message(bytes(data), TOPICS[connection.topic][1])
            _same(ours, theirs)
        assert reader.ros_distro == installed()


def _same(ours: object, theirs: object) -> None:
    for field in getattr(ours, "get_fields_and_field_types", dict)():
        one, other = getattr(ours, field), getattr(theirs, field)
        if hasattr(one, "get_fields_and_field_types"):
            _same(one, other)
        elif isinstance(one, (str, int, float, bool)):
            assert one == other, field
        else:
            assert len(one) == len(other), field


@pytest.mark.thorough
def test_a_topic_that_appears_later_and_one_that_changes_its_qos(domain, tmp_path: Path):
    folder = tmp_path / "bag"
    with recording(domain, folder, "/bag/text", "/bag/pose") as recorder:
        with talking(domain, "tests.support.bag_talker", "/bag/text") as first:
            publish(first, 50)
        with talking(domain, "tests.support.bag_talker", "/bag/pose", "/bag/text") as second:
            publish(second, 50)
        assert recorder.end() == 0
    assert contents(folder, "/bag/text") == published("/bag/text", 50) * 2
    assert decoded(folder, "/bag/pose") == [TOPICS["/bag/pose"][0](k) for k in range(50)]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "files"),
    [
        (["-b", "8k"], "bag_[0-9]+.mcap"),
        (["-d", "0.2"], "bag_[0-9]+.mcap"),
        (["-b", "8k", "--compression-mode", "file"], "bag_[0-9]+.mcap.zstd"),
        (["--compression-mode", "message", "--compression-format", "zstd"], "bag_0.mcap"),
        (["--storage-preset-profile", "none"], "bag_0.mcap"),
        (["--storage-preset-profile", "none", "-b", "0", "-d", "0"], "bag_0.mcap"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_splitting_and_compression(domain, tmp_path: Path, words: list[str], files: str):
    folder = tmp_path / "bag"
    topics = ["/bag/text", "/bag/big"]
    with (
        talking(domain, "tests.support.bag_talker", *topics) as talker,
        recording(domain, folder, "--topics", *topics, *words) as recorder,
    ):
        publish(talker, 100, 0.01)
        assert recorder.end() == 0, recorder.text
    for topic in topics:
        assert contents(folder, topic) == published(topic, 100)
    names = [path.name for path in folder.iterdir() if path.name != metadata.FILE]
    assert all(re.fullmatch(files, name) for name in names)
    assert (len(names) > 1) == (words[0] in ("-b", "-d"))
    assert check.check(str(folder)).is_whole
    with Reader(folder) as reader:
        assert reader.message_count == 200
        assert len(list(reader.messages())) == 200


@pytest.mark.thorough
def test_killed_it_leaves_a_bag_that_repair_makes_whole(domain, tmp_path: Path):
    folder = tmp_path / "bag"
    with (
        talking(domain, "tests.support.bag_talker") as talker,
        recording(domain, folder, "-a") as recorder,
    ):
        publish(talker, 300, 0.005)
        # a flush follows each second
        wait_until(lambda: len(contents(folder, "/bag/text")) >= 100, "a written chunk")
        recorder.end(signal.SIGKILL)
    before = contents(folder, "/bag/text")
    assert launcher(domain, "bag", "check", str(folder)).code == 1
    repaired = launcher(domain, "bag", "check", "--repair", str(folder))
    assert repaired.code == 0, repaired
    assert contents(folder, "/bag/text") == before == published("/bag/text", len(before))
    with Reader(folder) as reader:
        assert len(list(reader.messages())) == reader.message_count


def test_a_full_disk_ends_it_with_a_whole_bag(domain, tmp_path: Path):
    folder, limit = tmp_path / "bag", 3_000_000
    words = ("/bag/big", "--storage-preset-profile", "none")
    with (
        talking(domain, "tests.support.bag_talker", "/bag/big") as talker,
        recording(domain, folder, *words, file_limit=limit) as recorder,
    ):
        publish(talker, 30)
        assert recorder.wait() == 1
    assert "error: cannot write" in recorder.text
    assert "what was written before is a whole bag" in recorder.text
    found = contents(folder, "/bag/big")
    assert found
    assert found == published("/bag/big", len(found))
    assert check.check(str(folder)).is_whole
    assert os.path.getsize(folder / "bag_0.mcap") <= limit


@pytest.mark.thorough
@pytest.mark.parametrize("wait_s", [0.0, 0.02, 0.2])
def test_several_signals_at_once_end_it_as_one_does(domain, tmp_path: Path, wait_s: float):
    folder = tmp_path / "bag"
    with recording(domain, folder, "-a") as recorder:
        recorder.read_until("recording into")
        for signum in (signal.SIGINT, signal.SIGINT, signal.SIGTERM):
            if recorder.process.poll() is None:
                recorder.process.send_signal(signum)
            time.sleep(wait_s)
        assert recorder.wait() == 0, recorder.text
    assert check.check(str(folder)).is_whole
    assert metadata.read(str(folder)) is not None


@pytest.mark.thorough
def test_a_stderr_that_takes_nothing_is_no_end(domain, tmp_path: Path):
    words = ["-m", "launcher", "bag", "record", "-a", "-o", str(tmp_path / "bag"), "--for", "0.5"]
    with open("/dev/full", "w") as full:
        subprocess.run([sys.executable, *words], env=domain, stdout=full, stderr=full, timeout=60)
    assert check.check(str(tmp_path / "bag")).is_whole
    assert metadata.read(str(tmp_path / "bag")) is not None


@pytest.mark.thorough
def test_snapshots_of_what_is_in_memory(domain, tmp_path: Path):
    folder = tmp_path / "bag"
    with (
        talking(domain, "tests.support.bag_talker", "/bag/text") as talker,
        recording(domain, folder, "/bag/text", "--snapshot-mode") as recorder,
    ):
        publish(talker, 20)
        recorder.process.send_signal(signal.SIGUSR1)
        recorder.read_until("wrote 20 messages")
        publish(talker, 30)
        assert recorder.end() == 0
    assert contents(folder, "/bag/text") == published("/bag/text", 20)


@pytest.mark.thorough
def test_times_of_a_simulation_and_overrides_of_qos(domain, tmp_path: Path):
    clock = write_bag(tmp_path / "clock", counting("/tick", 600, 0.1))
    overrides = tmp_path / "qos.yaml"
    overrides.write_text("/bag/text: {reliability: best_effort, depth: 7}\n")
    play = [sys.executable, "-m", "launcher", "bag", "play", str(clock), "--clock", "100"]
    player = subprocess.Popen(play, env=domain, stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    words = ("/bag/text", "--use-sim-time", "--qos-profile-overrides-path", str(overrides))
    try:
        with (
            talking(domain, "tests.support.bag_talker", "/bag/text") as talker,
            recording(domain, tmp_path / "bag", *words) as recorder,
        ):
            wait_until(lambda: records(talker, tmp_path / "bag"), "a message with a time of /clock")
            info = launcher(domain, "topic", "info", "-v", "/bag/text").out
            publish(talker, 100, 0.01)
            assert recorder.end() == 0
    finally:
        player.send_signal(signal.SIGINT)
        player.wait(timeout=60)
    assert "BEST_EFFORT" in info
    found = list(Bag(str(tmp_path / "bag")).messages())
    assert found
    end_ns = START_NS + 60 * 10**9
    assert all(START_NS <= one.log_ns <= end_ns < one.publish_ns for one in found)


@pytest.mark.thorough
def test_the_space_key_pauses_and_the_status_tells_what_is_going_on(domain, tmp_path: Path):
    words = ["-m", "launcher", "bag", "record", "-o", str(tmp_path / "bag"), "/bag/text"]
    with talking(domain, "tests.support.bag_talker", "/bag/text") as talker:
        terminal = pexpect.spawn(
            sys.executable,
            [*words, "--start-paused"],
            env=domain,
            encoding="utf-8",
            dimensions=(24, 140),
            timeout=60,
        )
        try:
            terminal.expect(r"paused .*1 topic .* 0 lost")
            publish(talker, 20)
            terminal.send(" ")
            terminal.expect("recording ")
            publish(talker, 30)
            terminal.expect(r"30 messages .*/s .* written .* 0 lost")
            terminal.sendintr()
            terminal.expect_exact("wrote ")
            terminal.expect(pexpect.EOF)
        finally:
            terminal.close(force=True)
    assert contents(tmp_path / "bag", "/bag/text") == published("/bag/text", 30, first=20)


@pytest.mark.thorough
def test_what_is_not_there_is_told(domain, tmp_path: Path):
    with recording(domain, tmp_path / "none", "-a", "--for", "0.1") as recorder:
        assert recorder.wait() == 0
    assert "nothing was recorded: 0 nodes on domain" in recorder.text
    with (
        talking(domain, "tests.support.bag_talker", "/bag/text") as talker,
        recording(domain, tmp_path / "bag", "/bag/test", "/bag/text") as recorder,
    ):
        publish(talker, 1)
        recorder.read_until("/bag/test does not appear to be published yet")
        assert recorder.end() == 0
    assert "(did you mean '/bag/text'?)" in recorder.text


def test_mistakes(tmp_path: Path, domain):
    def errors(*words: str) -> tuple[int, str]:
        answer = launcher(domain, "bag", "record", *words)
        return answer.code, answer.err

    assert errors() == (
        2,
        "error: nothing to record was named\n"
        "hint: -a records all topics; or name topics, or --regex\n",
    )
    (tmp_path / "there").mkdir()
    code, text = errors("-a", "-o", str(tmp_path / "there"))
    assert code == 1
    assert "exists already" in text
    code, text = errors("-a", "-o", "/proc/x/bag")
    assert (code, text.startswith("error: cannot write /proc/x/bag")) == (1, True)
    assert errors("--regex", "[")[0] == 2
    file = tmp_path / "qos.yaml"
    file.write_text("/x: {reliability: sometimes}")
    code, text = errors("-a", "--qos-profile-overrides-path", str(file))
    assert code == 2
    assert "/x: unknown reliability 'sometimes'" in text


@pytest.mark.parametrize(
    "words",
    few_of([["bad name"], ["--topics", "/a//b"], ["--services", "a-b"]], [["bad name"]]),
)
def test_names_that_no_topic_can_have(domain, tmp_path: Path, words: list[str]):
    done = launcher(domain, "bag", "record", "-o", str(tmp_path / "bag"), *words)
    assert done.code == 2, done
    assert "Invalid topic name" in done.err
    assert not (tmp_path / "bag").exists()
