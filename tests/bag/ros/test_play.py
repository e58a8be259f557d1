"""`bag play`: subscriptions receive what the bag has, in its order and at its times."""

from __future__ import annotations

import contextlib
import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import pexpect
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from launcher.bag.bag_model import Topic
from launcher.bag.metadata import FILE
from launcher.bag.writer import BagWriter
from tests.bag.ros.test_record import contents, recording
from tests.support.bags import QOS, START_NS, counting, string_cdr, string_topic, write_bag
from tests.support.node_process import line_of
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import launcher
from tests.support.waiting import wait_until

STRING = "std_msgs/msg/String"
PERIOD_NS = 4_000_000
RIGHT, UP, DOWN = "\x1b[C", "\x1b[A", "\x1b[B"
PADDED = [string_cdr(f"message {n}") for n in range(1000)]
PLAY = (sys.executable, "-m", "launcher", "bag", "play")
PADDED = [one + bytes(-len(one) % 4) for one in PADDED]


@pytest.fixture
def domain(tmp_path: Path) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path / "log") as env:
        yield env


def heard(listener: subprocess.Popen[str], count: int) -> list[list]:
    """The next messages of the listener."""
    return [json.loads(line_of(listener.stdout)) for _ in range(count)]


def listening(env: dict[str, str], *words: str):
    return talking(env, "tests.support.bag_listener", *words)


@contextlib.contextmanager
def playing(env: dict[str, str], *words: str) -> Iterator[subprocess.Popen[str]]:
    """A player, interrupted at the end."""
    with subprocess.Popen(
        [*PLAY, *words], env=env, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as player:
        try:
            yield player
        finally:
            player.send_signal(signal.SIGINT)
            assert player.wait(timeout=60) == 0


def test_everything_is_published_in_order_at_its_times(domain, tmp_path: Path):
    bag = write_bag(tmp_path / "bag", counting("/chatter", 500, PERIOD_NS / 1e9))
    with listening(domain, f"/chatter={STRING}") as listener:
        answer = launcher(domain, "bag", "play", str(bag))
        found = heard(listener, 500)
    assert (answer.code, answer.out) == (0, ""), answer
    assert answer.err == "playing 1 topic\nplayed 500 messages\n"
    assert [bytes.fromhex(data) for _, data, _ in found] == PADDED[:500]
    times = [ns for *_, ns in found]
    late = [ns - n * PERIOD_NS for n, ns in enumerate(times)]  # all from one unknown start
    # On a busy machine any message may be late, also the first one, and several are sent at once;
    # the last of them is late by less than a period. How late most are: benchmarks, `bag-play`.
    assert abs(min(late[250:]) - min(late[:250])) < 2 * PERIOD_NS


@pytest.mark.thorough
@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_bags_that_another_library_wrote(domain, tmp_path: Path, plugin):
    store = get_typestore(Stores.ROS2_JAZZY)
    kind = store.types[STRING]
    with Writer(tmp_path / "bag", version=9, storage_plugin=plugin) as writer:
        connection = writer.add_connection("/chatter", STRING, typestore=store)
        for n in range(100):
            data = store.serialize_cdr(kind(data=f"message {n}"), STRING)
            writer.write(connection, START_NS + n * 10**6, data)
    with listening(domain, f"/chatter={STRING}") as listener:
        assert launcher(domain, "bag", "play", str(tmp_path / "bag")).code == 0
        assert [bytes.fromhex(one[1]) for one in heard(listener, 100)] == PADDED[:100]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--start-offset", "0.5", "--rate", "10"], range(50, 100)),
        (["--playback-duration", "0.2"], range(21)),
        (["--start-offset", "0.9", "--playback-duration", "0.05"], range(90, 96)),
        (["--playback-until-sec", "1700000000.1"], range(11)),
        (["--remap", "/chatter:=/other", "--rate", "20"], range(100)),
        (["--topics", "chatter", "--rate", "20"], range(100)),
        (["--regex", "chat", "--exclude-topics", "/b", "--rate", "20"], range(100)),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_what_options_select(domain, tmp_path: Path, words: list[str], expected: range):
    bag = write_bag(tmp_path / "bag", [*counting("/chatter", 100, 0.01), *counting("/b", 3)])
    topic = "/other" if "--remap" in words else "/chatter"
    with listening(domain, f"{topic}={STRING}") as listener:
        answer = launcher(domain, "bag", "play", str(bag), *words)
        assert answer.code == 0, answer
        found = [bytes.fromhex(data) for _, data, _ in heard(listener, len(expected))]
    assert found == [PADDED[n] for n in expected]


@pytest.mark.thorough
def test_several_bags_are_played_together(domain, tmp_path: Path):
    first = write_bag(tmp_path / "first", counting("/chatter", 20, 0.01)[::2])
    second = write_bag(tmp_path / "second", counting("/chatter", 20, 0.01)[1::2])
    with listening(domain, f"/chatter={STRING}") as listener:
        assert launcher(domain, "bag", "play", str(first), str(second)).code == 0
        assert [bytes.fromhex(one[1]) for one in heard(listener, 20)] == PADDED[:20]


@pytest.mark.thorough
def test_latched_topics_stay_latched(domain, tmp_path: Path):
    writer = BagWriter(str(tmp_path / "bag"))
    topic = string_topic("/map")
    latched = {**QOS, "durability": "transient_local"}
    writer.add_topic(topic)
    writer.set_qos("/map", [latched])
    writer.write(counting("/map", 1)[0])
    writer.close()
    # A topic that is played for as long as it takes a late subscription to discover it
    writer = BagWriter(str(tmp_path / "long"))
    writer.add_topic(string_topic("/tick"))
    for one in counting("/tick", 600, 0.1):
        writer.write(one)
    writer.close()
    with playing(domain, str(tmp_path / "bag"), str(tmp_path / "long")) as player:
        assert "playing 2 topics" in line_of(player.stderr)
        with listening(domain, "--latched", f"/map={STRING}") as listener:
            assert bytes.fromhex(heard(listener, 1)[0][1]) == PADDED[0]


@pytest.mark.thorough
def test_the_clock_is_that_of_the_bag(domain, tmp_path: Path):
    bag = str(write_bag(tmp_path / "bag", counting("/chatter", 1000, 0.1)))
    with (
        listening(domain, "/clock=rosgraph_msgs/msg/Clock") as listener,
        playing(domain, bag, "--clock", "50"),
    ):
        stamps = [_stamp(one[1]) for one in heard(listener, 30)]
    assert stamps == sorted(stamps)
    assert stamps[0] >= START_NS
    assert START_NS + 500_000_000 <= stamps[-1] <= START_NS + 100 * 10**9


@pytest.mark.thorough
def test_the_clock_begins_when_its_subscriptions_are_connected(domain, tmp_path: Path):
    bag = str(write_bag(tmp_path / "bag", counting("/chatter", 10)))
    with listening(domain, "/clock=rosgraph_msgs/msg/Clock") as listener:
        # A tick every 10 s, so at the beginning of this bag only
        assert launcher(domain, "bag", "play", bag, "--clock", "0.1").code == 0
        assert _stamp(heard(listener, 1)[0][1]) >= START_NS


def _stamp(data: str) -> int:
    raw = bytes.fromhex(data)
    return int.from_bytes(raw[4:8], "little") * 10**9 + int.from_bytes(raw[8:12], "little")


@pytest.mark.thorough
def test_loop_until_interrupted(domain, tmp_path: Path):
    bag = write_bag(tmp_path / "bag", counting("/chatter", 10, 0.01))
    with (
        listening(domain, f"/chatter={STRING}") as listener,
        playing(domain, str(bag), "--loop") as player,
    ):
        found = [bytes.fromhex(data) for _, data, _ in heard(listener, 35)]
        player.send_signal(signal.SIGINT)
        assert player.wait(timeout=60) == 0
        assert player.stderr is not None
        error = player.stderr.read()
    assert found == [PADDED[n % 10] for n in range(35)]
    assert re.search(r"played \d+ messages\n$", error)


@pytest.mark.thorough
def test_recorded_calls_become_calls(domain, tmp_path: Path):
    folder, topic = tmp_path / "bag", "/bag/switch/_service_event"
    with listening(domain) as server, recording(domain, folder, "--all-services") as recorder:
        info = ("topic", "info", topic)
        wait_until(lambda: "Subscription count: 1" in launcher(domain, *info).out, "the recorder")
        for value in ("true", "false", "true"):
            words = ("service", "call", "/bag/switch", "std_srvs/srv/SetBool", f"data: {value}")
            assert launcher(domain, *words).code == 0
        heard(server, 3)
        wait_until(lambda: len(contents(folder, topic)) == 6, "events")
        assert recorder.end() == 0
    with listening(domain) as server:
        answer = launcher(domain, "bag", "play", str(folder), "--publish-service-requests")
        assert answer.code == 0, answer
        assert heard(server, 3) == [["/bag/switch", value] for value in (True, False, True)]
        assert answer.err.endswith("playing 1 topic\nsent 3 requests\n")
        words = ("bag", "play", str(folder), "--publish-service-requests")
        renamed = launcher(domain, *words, "--remap", "/bag/switch:=/other", "--spin-time", "1")
        assert renamed.code == 1, renamed
        assert "warning: no request was sent: /other is not there\n" in renamed.err
        whose = launcher(domain, *words, "--service-requests-source", "client_introspection")
        assert whose.code == 1, whose
        assert "sent 0 requests\nwarning: no request was sent: the events are of" in whose.err


def test_mistakes(domain, tmp_path: Path):
    bag = str(write_bag(tmp_path / "bag", counting("/chatter", 10)))

    def errors(*words: str) -> tuple[int, str]:
        answer = launcher(domain, "bag", "play", *words)
        return answer.code, answer.err

    assert errors(f"{bag}x") == (1, f"error: there is no bag at {bag}x\n")
    assert errors(bag, "--topics", "/none") == (
        1,
        "warning: /none is not in what is read\n"
        "no topic of the bag is played\nhint: it has /chatter\n",
    )
    assert errors(bag, "--start-offset", "5") == (
        2,
        "error: --start-offset is behind the end: the bag has 0.900 s\n",
    )
    assert errors(bag, "--rate", "-1")[0] == 2
    assert errors(bag, "--remap", "/a=/b")[0] == 2
    (tmp_path / "bag" / FILE).unlink()
    code, text = errors(bag, "--rate", "100")
    assert code == 0
    assert f"{bag}: it has no metadata.yaml" in text


REFUSED = {
    Topic(name="/drone-1/text", type=STRING): (
        "'/drone-1/text' is no name in ROS: topic name must not contain characters other than "
        "alphanumerics, '_', '~', '{', or '}'\n"
        "hint: --remap /drone-1/text:=NEW plays it with another name"
    ),
    Topic(name="/b", type="no_such_msgs/msg/String"): (
        "no_such_msgs/msg/String: The passed message type is invalid\n"
        "hint: did you mean std_msgs/msg/String?"
    ),
    Topic(name="/no", type=""): "the bag does not have its type",
    Topic(name="/old", type="std_msgs/String", serialization="ros1"): (
        "its messages are in 'ros1', and ROS 2 has CDR"
    ),
    Topic(name="/web", type=STRING, serialization="json"): (
        "its messages are in 'json', and ROS 2 has CDR"
    ),
}


def bag_of(folder: Path, topics: Iterable[Topic], count: int = 5) -> str:
    """Five messages of each topic."""
    writer = BagWriter(str(folder))
    for topic in topics:
        writer.add_topic(topic)
        for one in counting(topic.name, count, PERIOD_NS / 1e9):
            writer.write(one)
    writer.close()
    return str(folder)


@pytest.mark.thorough
def test_what_cannot_be_played_is_named_and_the_rest_is_played(domain, tmp_path: Path):
    bag = bag_of(tmp_path / "bag", [*REFUSED, string_topic("/chatter")])
    with listening(domain, f"/chatter={STRING}") as listener:
        answer = launcher(domain, "bag", "play", bag)
        notes = [f"{topic.name} is not played: {reason}\n" for topic, reason in REFUSED.items()]
        assert answer.err == "".join([*notes, "playing 1 topic\n", "played 5 messages\n"])
        assert answer.code == 0
        assert [bytes.fromhex(one[1]) for one in heard(listener, 5)] == PADDED[:5]


@pytest.mark.thorough
def test_topics_that_other_nodes_publish_are_named_in_one_warning(domain, tmp_path: Path):
    topics = map(string_topic, ("/bag/text", "/chatter", "/rosout"))
    bag = bag_of(tmp_path / "bag", topics)
    warning = (
        "warning: other nodes publish, too: /bag/text (/bag_talker); subscriptions get the "
        "messages of both\n"
        "hint: --remap /bag/text:=/bag/bag/text plays it with another name, "
        "--exclude-topics /bag/text leaves it out\n"
    )
    with talking(domain, "tests.support.bag_talker", "/bag/text"):
        answer = launcher(domain, "bag", "play", bag)
        assert answer.code == 0, answer
        assert answer.err == f"{warning}playing 3 topics\nplayed 15 messages\n"
        answer = launcher(domain, "bag", "play", bag, "--remap", "/bag/text:=/bag/other")
        assert answer.err == "playing 3 topics\nplayed 15 messages\n"


def test_nothing_that_can_be_played_is_an_error(domain, tmp_path: Path):
    bag = bag_of(tmp_path / "bag", REFUSED)
    answer = launcher(domain, "bag", "play", bag)
    assert (answer.code, answer.out) == (1, "")
    assert answer.err.count("is not played: ") == len(REFUSED)
    assert answer.err.endswith(
        "no topic of the bag is played\nhint: it has /b, /drone-1/text, /no, /old, /web\n"
    )


@pytest.mark.thorough
def test_another_name_and_qos_that_ros_does_not_know(domain, tmp_path: Path):
    odd = {**QOS, "reliability": "sometimes", "liveliness": "manual_by_node", "depth": 2**40}
    topic = replace(string_topic("/drone-1/text"), qos=[odd])
    bag = bag_of(tmp_path / "bag", [topic])
    with listening(domain, f"/drone_1/text={STRING}") as listener:
        words = ("bag", "play", bag, "--remap", "/drone-1/text:=/drone_1/text")
        assert launcher(domain, *words).code == 0
        assert [bytes.fromhex(one[1]) for one in heard(listener, 5)] == PADDED[:5]


@pytest.mark.thorough
def test_a_topic_has_one_type_in_all_bags_that_are_played(domain, tmp_path: Path):
    other = Topic(name="/chatter", type="std_msgs/msg/Int32")
    first = bag_of(tmp_path / "first", [string_topic("/chatter")])
    second = bag_of(tmp_path / "second", [other, string_topic("/b")])
    json_bag = bag_of(tmp_path / "json", [replace(string_topic("/b"), serialization="json")])
    with listening(domain, f"/chatter={STRING}") as listener:
        answer = launcher(domain, "bag", "play", json_bag, first, second)
        assert answer.code == 0, answer
        assert [bytes.fromhex(one[1]) for one in heard(listener, 5)] == PADDED[:5]
    assert "/chatter is not played: it is std_msgs/msg/Int32 in this bag" in answer.err
    assert "/b is not played: its messages are in 'json'" in answer.err
    assert answer.err.endswith("playing 2 topics\nplayed 10 messages\n")


@pytest.mark.thorough
def test_damaged_events_of_a_service_are_no_calls(domain, tmp_path: Path):
    events = Topic(name="/bag/switch/_service_event", type="std_srvs/srv/SetBool_Event")
    bag = bag_of(tmp_path / "bag", [events, string_topic("/chatter")])
    words = ("bag", "play", bag, "--publish-service-requests", "--spin-time", "1")
    answer = launcher(domain, *words)
    assert answer.code == 1, answer
    note = "an event of /bag/switch/_service_event is not played: failed to deserialize"
    assert answer.err.count(note) == 1
    end = "played 5 messages, sent 0 requests\nwarning: no request was sent: "
    assert f"{end}no request was played\n" in answer.err


@pytest.mark.thorough
def test_keys_pause_step_jump_and_change_the_rate(domain, tmp_path: Path):
    bag = write_bag(tmp_path / "bag", counting("/chatter", 300, 0.1))
    with listening(domain, f"/chatter={STRING}") as listener:
        terminal = pexpect.spawn(
            sys.executable,
            [*PLAY[1:], str(bag), "--start-paused"],
            env=domain,
            encoding="utf-8",
            dimensions=(24, 120),
            timeout=60,
        )
        try:
            terminal.expect_exact("playing 1 topic (space pauses")
            terminal.expect_exact("paused")
            terminal.send(RIGHT)
            assert bytes.fromhex(heard(listener, 1)[0][1]) == PADDED[0]
            terminal.send(RIGHT)
            assert bytes.fromhex(heard(listener, 1)[0][1]) == PADDED[1]
            terminal.send(UP)
            terminal.expect_exact("x1.10")
            terminal.send(DOWN + DOWN)
            terminal.expect_exact("x0.91")
            terminal.send(" ")
            terminal.expect_exact("playing [")
            assert bytes.fromhex(heard(listener, 1)[0][1]) == PADDED[2]
            terminal.send(RIGHT)  # 5 s further
            later = [bytes.fromhex(one[1]) for one in heard(listener, 60)]
            assert any(b.startswith(PADDED[60][:12]) for b in later)
            terminal.sendintr()
            terminal.expect_exact("played ")
            terminal.expect(pexpect.EOF)
            terminal.wait()
            assert terminal.exitstatus == 0
        finally:
            terminal.close(force=True)


@pytest.mark.thorough
def test_the_terminal_is_as_before(domain, tmp_path: Path):
    bag = write_bag(tmp_path / "bag", counting("/chatter", 300, 0.1))
    shell = pexpect.spawn("/bin/sh", [], env={**domain, "PS1": "$ "}, encoding="utf-8", timeout=60)
    try:
        shell.sendline("stty -a | md5sum")
        shell.expect(r"([0-9a-f]{32})")
        before = shell.match[1]
        shell.sendline(f"{sys.executable} -m launcher bag play {bag}; stty -a | md5sum")
        shell.expect_exact("playing [")
        shell.sendintr()
        shell.expect(r"([0-9a-f]{32})")
        assert shell.match[1] == before
    finally:
        shell.close(force=True)
