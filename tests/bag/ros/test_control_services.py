"""The services of recorder and player, with the types of Jazzy and of Lyrical."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from launcher.bag.reader import Bag
from tests.bag.ros.test_play import PADDED, STRING, heard, listening, playing
from tests.bag.ros.test_record import contents, publish, published, recording
from tests.support import rosbag2_interfaces
from tests.support.bags import START_NS, counting, write_bag
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import launcher
from tests.support.waiting import wait_until
from tests.support.workspaces import built_once

TALKER, TEXT = "tests.support.bag_talker", "/bag/text"
Call = Callable[..., dict]


@pytest.fixture
def distro() -> str:
    return "lyrical"


@pytest.fixture
def env(distro: str, tmp_path_factory, tmp_path: Path) -> Iterator[dict[str, str]]:
    packages = rosbag2_interfaces.write(tmp_path / "packages", distro)
    base = tmp_path_factory.getbasetemp()
    built = built_once(base, f"rosbag2_{distro}", packages)
    with ros_domain(tmp_path / "log") as env:
        yield built.environment(env)


def caller(env: dict[str, str], node: str) -> Call:
    """Calls a service of a node; the fields of its response."""

    def call(service: str, type_name: str, values: str = "{}") -> dict:
        kind = f"rosbag2_interfaces/srv/{type_name}"
        answer = launcher(env, "service", "call", f"/{node}/{service}", kind, values)
        assert answer.code == 0, answer
        text = answer.out.partition("response:\n")[2].strip()
        fields = re.sub(r"(\w+)=", r"\1: ", text[text.index("(") + 1 : text.rindex(")")])
        return yaml.safe_load(f"{{{fields}}}")

    return call


def code_of(response: dict) -> tuple[int, str]:
    return response["return_code"], response["error_string"]


@pytest.mark.thorough
def test_the_recorder_is_steered(env, tmp_path: Path):
    folder = tmp_path / "bag"
    call = caller(env, "keeper")
    with (
        talking(env, TALKER, TEXT) as talker,
        recording(env, folder, TEXT, "--node-name", "keeper") as recorder,
    ):
        publish(talker, 10)
        call("pause", "Pause")
        assert call("is_paused", "IsPaused") == {"paused": True}
        publish(talker, 10)
        call("resume", "Resume")
        publish(talker, 10)
        wait_until(lambda: len(contents(folder, TEXT)) == 20, "both parts")
        call("split_bagfile", "SplitBagfile")
        publish(talker, 5)
        assert call("is_discovery_running", "IsDiscoveryRunning") == {"running": True}
        again = (1, "Discovery is already running.")
        assert code_of(call("start_discovery", "StartDiscovery")) == again
        assert code_of(call("stop_discovery", "StopDiscovery")) == (0, "")
        assert call("is_discovery_running", "IsDiscoveryRunning") == {"running": False}
        busy = (1, "Called record(uri) while already in recording.")
        assert code_of(call("record", "Record")) == busy
        assert code_of(call("stop", "Stop")) == (0, "")
        recorder.read_until("wrote ")
        assert code_of(call("stop", "Stop")) == (1, "Recorder is already stopped.")
        assert code_of(call("record", "Record", "{uri: ''}")) == (0, "")
        publish(talker, 7)
        assert recorder.end() == 0, recorder.text
    expected = published(TEXT, 10) + published(TEXT, 15, first=20)
    assert contents(folder, TEXT) == expected
    assert [Path(file).name for file in Bag(str(folder)).files] == ["bag_0.mcap", "bag_1.mcap"]
    assert contents(tmp_path / "bag(1)", TEXT) == published(TEXT, 7, first=35)


@pytest.mark.thorough
def test_what_is_due_at_a_time(env, tmp_path: Path):
    """Splitting and resuming at times of messages, recording at one of the clock."""
    folder = tmp_path / "bag"
    call = caller(env, "rosbag2_recorder")
    with (
        talking(env, TALKER, TEXT) as talker,
        recording(env, folder, TEXT, "--start-paused") as recorder,
    ):
        bad = call("split_bagfile", "SplitBagfile", "{split_mode: 7}")
        assert code_of(bad) == (2, "Invalid split_mode for SplitBagfile request.")
        bad = call("resume", "Resume", "{resume_mode: -1}")
        assert code_of(bad) == (1, "Invalid resume_mode for Resume request.")
        at = "{resume_time: {sec: 1}, resume_mode: 1, tracking_topic_name: bag/text}"
        assert code_of(call("resume", "Resume", at)) == (0, "")
        at = "{split_time: {sec: 1}, split_mode: 2, tracking_topic_name: /other}"
        assert code_of(call("split_bagfile", "SplitBagfile", at)) == (0, "")
        publish(talker, 10)  # the first one is after the time
        at = "{split_time: {sec: 1}, split_mode: 2}"
        assert code_of(call("split_bagfile", "SplitBagfile", at)) == (0, "")
        publish(talker, 10)
        assert recorder.end() == 0, recorder.text
    assert contents(folder, TEXT) == published(TEXT, 20)
    assert len(Bag(str(folder)).files) == 2


@pytest.mark.thorough
def test_snapshots_are_asked_for(env, tmp_path: Path):
    call = caller(env, "rosbag2_recorder")
    with (
        talking(env, TALKER, TEXT) as talker,
        recording(env, tmp_path / "bag", TEXT, "--snapshot-mode") as recorder,
    ):
        publish(talker, 10)
        assert call("snapshot", "Snapshot") == {"success": True}
        assert recorder.end() == 0, recorder.text
    assert contents(tmp_path / "bag", TEXT) == published(TEXT, 10)


@pytest.mark.thorough
def test_what_was_lost_is_published(env, tmp_path: Path):
    folder, lost = tmp_path / "bag", "/events/rosbag2_messages_lost"
    words = ("--max-cache-size", "1", "--stats_max_publishing_rate", "1000")
    with (
        talking(env, TALKER, "/bag/big") as talker,
        recording(env, folder, "/bag/big", lost, *words) as recorder,
    ):
        info = ("topic", "info", lost)
        wait_until(lambda: "Subscription count: 1" in launcher(env, *info).out, "the recorder")
        publish(talker, 100)
        wait_until(lambda: contents(folder, lost), "an event")
        assert recorder.end() == 0, recorder.text
    dropped = re.search(r"warning: Number of messages lost in the recorder: (\d+)", recorder.text)
    assert dropped is not None, recorder.text
    events = decoded(folder / "bag_0.mcap", lost)
    assert {one.node_name for one in events} == {"/rosbag2_recorder"}
    topics = [topic for one in events for topic in one.messages_lost_statistics]
    assert {topic.topic_name for topic in topics} <= {"/bag/big", lost}
    numbers = [topic.messages_lost_in_recorder for topic in topics]
    assert 0 < sum(numbers) <= int(dropped[1])
    assert len(contents(folder, "/bag/big")) <= 100 - max(numbers)


def decoded(file: Path, topic: str) -> list:
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [one.decoded_message for one in reader.iter_decoded_messages(topics=[topic])]


@pytest.mark.thorough
def test_the_player_is_steered(env, tmp_path: Path):
    bag = str(write_bag(tmp_path / "bag", counting("/chatter", 3000, 0.1)))
    call = caller(env, "rosbag2_player")
    with (
        listening(env, f"/chatter={STRING}") as listener,
        playing(env, bag, "--start-paused") as player,
    ):
        assert call("is_paused", "IsPaused") == {"paused": True}
        assert call("play_next", "PlayNext") == {"success": True}
        assert call("burst", "Burst", "{num_messages: 4}") == {"actually_burst": 4}
        seconds = START_NS // 10**9 + 20
        assert call("seek", "Seek", f"{{time: {{sec: {seconds}}}}}") == {"success": True}
        assert call("play_next", "PlayNext") == {"success": True}
        found = [bytes.fromhex(one[1]) for one in heard(listener, 6)]
        assert found == [*PADDED[:5], PADDED[200]]
        assert call("set_rate", "SetRate", "{rate: -1.0}") == {"success": False}
        assert call("set_rate", "SetRate", "{rate: 2.0}") == {"success": True}
        assert call("get_rate", "GetRate") == {"rate": 2.0}
        call("toggle_paused", "TogglePaused")
        assert call("is_paused", "IsPaused") == {"paused": False}
        assert call("play_next", "PlayNext") == {"success": False}
        assert call("play", "Play") == {"success": False}
        assert call("resume", "Resume", "{resume_mode: 1}")["return_code"] == 1
        call("stop", "Stop")
        assert player.wait(timeout=60) == 0


@pytest.mark.thorough
@pytest.mark.parametrize("distro", ["jazzy"])
def test_the_types_of_jazzy_have_fewer_fields(env, tmp_path: Path):
    folder = tmp_path / "bag"
    call = caller(env, "rosbag2_recorder")
    with (
        talking(env, TALKER, TEXT) as talker,
        recording(env, folder, TEXT, "--start-paused") as recorder,
    ):
        assert call("is_paused", "IsPaused") == {"paused": True}
        call("resume", "Resume")
        assert call("is_paused", "IsPaused") == {"paused": False}
        publish(talker, 10)
        call("split_bagfile", "SplitBagfile")
        publish(talker, 10)
        call("stop", "Stop")
        recorder.read_until("wrote ")
        call("stop", "Stop")
        assert code_of(call("record", "Record", "{uri: ''}")) == (0, "")
        assert recorder.end() == 0, recorder.text
    assert contents(folder, TEXT) == published(TEXT, 20)
    assert len(Bag(str(folder)).files) == 2
    call = caller(env, "rosbag2_player")
    bag = str(write_bag(tmp_path / "other", counting("/chatter", 3000, 0.1)))
    with playing(env, bag, "--start-paused") as player:
        call("resume", "Resume")
        assert call("is_paused", "IsPaused") == {"paused": False}
        call("stop", "Stop")
        assert player.wait(timeout=60) == 0
