"""`bag record`: rings of files, repeated messages, static topics, and topics that never come."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from launcher.bag import metadata
from launcher.bag.reader import Bag
from tests.bag.ros.test_record import contents, decoded, publish, published, recording
from tests.support.bag_talker import TOPICS
from tests.support.bags import agreed_counts
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import launcher
from tests.support.waiting import wait_until

TALKER = "tests.support.bag_talker"


@pytest.fixture
def domain(tmp_path: Path) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path / "log") as env:
        yield env


def poses_in(file: Path) -> list[float]:
    """By another reader: the numbers of the poses in a file."""
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        found = reader.iter_decoded_messages(topics=["/bag/pose"])
        return [one.decoded_message.pose.position.x / 0.25 for one in found]


def number_of_files(folder: Path) -> int:
    return len(list(folder.glob("*.mcap")))


@pytest.mark.thorough
@pytest.mark.parametrize(
    "repeat",
    [["--repeat-transient-local", "bag/pose=2"], ["--repeat-all-transient-local", "2"]],
    ids=["named", "all"],
)
def test_a_ring_of_files_that_begin_with_the_last_latched_messages(domain, tmp_path: Path, repeat):
    folder = tmp_path / "bag"
    words = ("-b", "8k", "--storage-preset-profile", "none", "--max-bag-files", "2", *repeat)
    with (
        talking(domain, TALKER, "/bag/pose") as poses,
        talking(domain, TALKER, "/bag/text") as texts,
        recording(domain, folder, *words, "--topics", "/bag/pose", "/bag/text") as recorder,
    ):
        publish(poses, 3)
        wait_until(lambda: len(decoded(folder, "/bag/pose")) == 3, "the poses")
        publish(texts, 600)
        recorder.read_until("Deleted oldest bagfile: bag_0.mcap (")
        assert recorder.end() == 0, recorder.text
    assert number_of_files(folder) == 2
    assert [poses_in(file) for file in folder.glob("*.mcap")] == [[1.0, 2.0]] * 2
    counts = agreed_counts(folder)
    assert counts["/bag/pose"] == 4
    last = contents(folder, "/bag/text")
    assert last == published("/bag/text", len(last), first=600 - len(last))
    known = metadata.read(str(folder))
    assert known is not None
    assert known.extent.counts == counts


@pytest.mark.thorough
def test_a_snapshot_begins_with_the_last_latched_messages(domain, tmp_path: Path):
    folder = tmp_path / "bag"
    words = ("--snapshot-mode", "--max-cache-size", "0", "--max-cache-duration", "1")
    with (
        talking(domain, TALKER, "/bag/pose") as poses,
        talking(domain, TALKER, "/bag/text") as texts,
        recording(
            domain, folder, *words, "--repeat-transient-local", "/bag/pose", "-a", "-x", "^/[^b]"
        ) as recorder,
    ):
        publish(poses, 1)
        publish(texts, 150, 0.01)
        recorder.process.send_signal(signal.SIGUSR1)
        recorder.read_until("wrote ")
        assert recorder.end() == 0, recorder.text
    assert decoded(folder, "/bag/pose") == [TOPICS["/bag/pose"][0](0)]
    found = list(Bag(str(folder)).messages())
    assert found[0].topic == "/bag/pose"
    assert found[0].log_ns == found[1].log_ns
    assert found[-1].log_ns - found[0].log_ns <= 10**9
    last = contents(folder, "/bag/text")
    assert 1 < len(last) < 150
    assert last == published("/bag/text", len(last), first=150 - len(last))


@pytest.mark.thorough
def test_static_topics_are_subscribed_to_before_they_are_published(domain, tmp_path: Path):
    file = tmp_path / "topics.yaml"
    file.write_text("static_topics_and_types_list: [[/bag/text, std_msgs/msg/String]]\n")
    folder = tmp_path / "bag"
    with recording(domain, folder, "--static-topics-path", str(file)) as recorder:
        info = ("topic", "info", "/bag/text")
        wait_until(lambda: "Subscription count: 1" in launcher(domain, *info).out, "the recorder")
        for _ in range(2):  # it goes on when the publisher has gone
            with talking(domain, TALKER, "/bag/text") as talker:
                publish(talker, 20)
        assert recorder.end() == 0, recorder.text
    assert contents(folder, "/bag/text") == published("/bag/text", 20) * 2


@pytest.mark.thorough
def test_topics_that_nobody_publishes(domain, tmp_path: Path):
    def record(name: str, *words: str) -> tuple[int, str]:
        answer = launcher(domain, "bag", "record", "-o", str(tmp_path / name), *words, "--for", "1")
        return answer.code, answer.err

    code, text = record("none", "/bag/text", "/bag/pose")
    assert code == 1
    assert "warning: /bag/text was not published\n" in text
    assert "warning: /bag/pose was not published\n" in text
    assert "nothing was recorded" in text
    code, text = record("others", "--services", "/call", "--actions", "/act")
    assert code == 1
    assert "warning: service /call did not publish its calls\n" in text
    assert "warning: action /act was not there\n" in text
    with talking(domain, TALKER, "/bag/text"):
        file = tmp_path / "topics.yaml"
        file.write_text("static_topics_and_types_list: [[/bag/text, std_msgs/msg/Int32]]")
        words = ("--static-topics-path", str(file), "--spin-time", "60")
        code, text = record("another type", *words)
        assert code == 1
        assert "/bag/text with std_msgs/msg/String is not recorded: it is recorded with" in text
        code, text = record("some", "/bag/text", "/bag/pose", "--spin-time", "60")
    assert code == 0
    assert "/bag/text was not published" not in text
    assert "warning: /bag/pose was not published" in text


@pytest.mark.thorough
def test_leaves_are_ignored_and_data_is_noted(domain, tmp_path: Path):
    folder = tmp_path / "bag"
    words = ("--ignore-leaf-topics", "--custom-data", "a=1", "b=2", "--custom-data", "c=3")
    listener = "/bag/text=std_msgs/msg/String"
    with (
        talking(domain, TALKER, "/bag/text", "/bag/pose"),
        talking(domain, "tests.support.bag_listener", listener),
        recording(domain, folder, "-e", "^/bag/", *words) as recorder,
    ):
        info = ("topic", "info", "/bag/text")
        wait_until(lambda: "Subscription count: 2" in launcher(domain, *info).out, "the recorder")
        assert recorder.end() == 0, recorder.text
    known = metadata.read(str(folder))
    assert known is not None
    assert known.custom_data == {"a": "1", "b": "2", "c": "3"}
    assert [topic.name for topic in known.topics] == ["/bag/text"]
