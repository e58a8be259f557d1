"""`bag convert`: what is kept, where it goes, and what it refuses."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from launcher.bag import metadata
from launcher.bag.bag_model import BagError, Message, Topic
from launcher.bag.converting.time_texts import Moment, moment
from launcher.bag.reader import Bag
from launcher.base.errors import LauncherError, UsageError
from tests.support.bags import (
    START_NS,
    contents,
    convert,
    counting,
    imu_bag,
    message,
    string_cdr,
    string_topic,
    typed_bag,
    write_bag,
)

YAML = """
output_bags:
- uri: {folder}/one
  storage_id: mcap
  all: true
  exclude: b$
  max_bagfile_duration: 2
  max_cache_size: 1000
- uri: {folder}/two
  topics: [b]
  compression_mode: file
  compression_format: zstd
  start_time_ns: 1700000000500000000
"""


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    ordered = sorted(
        [*counting("/a", 100), *counting("/b", 10)], key=lambda one: (one.log_ns, one.topic)
    )
    return write_bag(tmp_path / "whole", ordered)


def numbers(path: Path) -> list[int]:
    return [int(text.split()[1]) for _, text in contents(path)]


def test_everything_is_copied_as_it_is(tmp_path: Path, whole: Path):
    convert(whole, "-o", tmp_path / "copy")
    before, after = Bag(str(whole)), Bag(str(tmp_path / "copy"))
    assert list(after.messages()) == list(before.messages())
    assert after.topics == before.topics
    assert after.metadata.ros_distro == "jazzy"


def test_other_libraries_read_it(tmp_path: Path, whole: Path):
    convert(whole, "-o", tmp_path / "copy", "--topics", "/b")
    with Reader(tmp_path / "copy") as reader:
        read = [(one.topic, at_ns, bytes(data)) for one, at_ns, data in reader.messages()]
    expected = [(one.topic, one.log_ns, one.data) for one in counting("/b", 10)]
    assert read == expected
    convert(whole, "-o", tmp_path / "one.mcap", "--topics", "b")
    with (tmp_path / "one.mcap").open("rb") as stream:
        found = [(c.topic, m.log_time, m.data) for _, c, m in make_reader(stream).iter_messages()]
    assert found == expected


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--start", "2", "--end", "2.3"], [20, 21, 22]),
        (["--start-offset", "2", "--duration", "0.3"], [20, 21, 22]),
        (["--duration", "0.2"], [0, 1]),
        (["--start", "1700000009.8"], [98, 99]),
        (["--start", "2023-11-14T22:13:29.800Z"], [98, 99]),
        (["--start", "2023-11-15T00:13:29.800+02:00", "--duration", "0.1"], [98]),
        (["--end", "0.1"], [0]),
    ],
)
def test_times(tmp_path: Path, whole: Path, words: list[str], expected: list[int]):
    convert(whole, "-o", tmp_path / "cut", "--topics", "/a", *words)
    assert numbers(tmp_path / "cut") == expected


def test_a_moment_is_exact():
    assert moment("1700000000.123456789") == Moment(1700000000123456789, from_start=False)
    assert moment("0.1") == Moment(10**8, from_start=True)


@pytest.mark.parametrize(
    ("words", "topics"),
    [
        (["--topics", "/a"], {"/a"}),
        (["-e", "b$"], {"/b"}),
        (["-x", "b$"], {"/a"}),
        (["--exclude-topics", "/a"], {"/b"}),
        (["--topics", "a", "b", "--exclude-topics", "/a"], {"/b"}),
    ],
)
def test_topics(tmp_path: Path, whole: Path, words: list[str], topics: set[str]):
    convert(whole, "-o", tmp_path / "cut", *words)
    assert {topic for topic, _ in contents(tmp_path / "cut")} == topics
    assert {topic.name for topic in Bag(str(tmp_path / "cut")).topics} == topics


def test_bags_are_merged_in_the_order_of_times(tmp_path: Path):
    first = write_bag(tmp_path / "1", counting("/a", 10))
    later = [message("/a", n / 10 + 0.05, f"later {n}") for n in range(10)]
    second = write_bag(tmp_path / "2", [*later, message("/c", 2, "c 1")])
    convert(first, "-i", second, "mcap", "-o", tmp_path / "out", "--remap", "c:=/d")
    assert [one.name for one in Bag(str(tmp_path / "out")).topics] == ["/a", "/d"]
    found = contents(tmp_path / "out")
    assert found[:3] == [("/a", "message 0"), ("/a", "later 0"), ("/a", "message 1")]
    assert found[-1] == ("/d", "c 1")
    assert len(found) == 21


@pytest.mark.parametrize(
    ("other", "text"),
    [
        (Topic(name="/a", type="x_msgs/msg/X"), "/a is std_msgs/msg/String in .*1 and x_msgs/msg/"),
        (replace(string_topic("/a"), type_hash="RIHS01_0"), "not defined in the same way in .*2"),
    ],
)
def test_topics_of_other_types_are_not_merged(tmp_path: Path, other: Topic, text: str):
    first = write_bag(tmp_path / "1", counting("/a", 1))
    second = typed_bag(tmp_path / "2", other)
    with pytest.raises(BagError, match=text):
        convert(first, second, "-o", tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "files"), [(["-d", "2"], 5), (["-b", "2k"], 4), (["-b", "100M"], 1)]
)
def test_split(tmp_path: Path, whole: Path, words: list[str], files: int):
    convert(whole, "-o", tmp_path / "out", "--storage-preset-profile", "none", *words)
    assert len(Bag(str(tmp_path / "out")).files) >= files
    assert len(contents(tmp_path / "out")) == 110


@pytest.mark.parametrize("mode", ["file", "message"])
def test_compressed_both_ways(tmp_path: Path, whole: Path, mode: str):
    convert(whole, "-o", tmp_path / "small", "--compression-mode", mode)
    assert metadata.read(str(tmp_path / "small")).compression_mode == mode
    with Reader(tmp_path / "small") as reader:
        assert len(list(reader.messages())) == 110
    convert(tmp_path / "small", "-o", tmp_path / "large")
    assert list(Bag(str(tmp_path / "large")).messages()) == list(Bag(str(whole)).messages())


def test_a_database_becomes_mcap(tmp_path: Path):
    folder = imu_bag(tmp_path / "db")
    convert(folder, "-o", tmp_path / "out")
    before, after = Bag(str(folder)), Bag(str(tmp_path / "out"))
    assert (before.storage, after.storage) == ("sqlite3", "mcap")
    assert list(after.messages()) == list(before.messages())
    assert after.topics == before.topics
    assert all(topic.definition for topic in after.topics)
    store = get_typestore(Stores.ROS2_JAZZY)
    with Reader(tmp_path / "out") as reader:
        for connection, _, data in reader.messages(reader.connections[:1]):
            decoded = store.deserialize_cdr(data, connection.msgtype)
            assert decoded.orientation.w == 1.0


def test_definitions_that_a_database_lacks_are_those_of_the_installed_types(tmp_path: Path):
    import sqlite3

    folder = imu_bag(tmp_path / "db")
    with sqlite3.connect(next(folder.glob("*.db3"))) as database:
        database.execute("DROP TABLE message_definitions")
        database.execute("UPDATE topics SET type_description_hash = ''")
    database.close()
    convert(folder, "-o", tmp_path / "out")
    topic = Bag(str(tmp_path / "out")).topic("/imu")
    assert topic.definition.text.count("MSG: ") == 4
    assert topic.type_hash.startswith("RIHS01_")
    convert(folder, "-o", tmp_path / "out.csv", "--topics", "/imu")
    assert (tmp_path / "out.csv").read_text().count("\n") == 4


@pytest.mark.parametrize(
    ("words", "text", "hint"),
    [
        ([], "-o OUT is missing", "a new folder"),
        (["-o", "-"], "a bag cannot be written to stdout", "--to csv"),
        (["-o", "x.csv", "-d", "1"], "--max-bag-duration is for bags", "-o DIR"),
        (["-o", "x.mcap", "-b", "1"], "--max-bag-size is for bags", "-o DIR"),
        (["-o", "x", "--field", "data"], "--field is for tables", "--to csv"),
        (["-o", "x", "--remap", "/a=/b"], "'/a=/b' is not OLD:=NEW", "--remap OLD:=NEW"),
        (["-o", "x", "--start", "noon"], "'noon' is neither a number of seconds nor a date", None),
        (["-o", "x", "--start", "-1"], "'-1' is not a number of seconds: it is below 0", None),
        (["-o", "x", "--start", "1", "--start-offset", "1"], "exclude each other", None),
        (["-o", "x", "-e", "("], r"'\(' is not a regular expression", None),
        (["-o", "x", "--to", "db3"], "'db3' is not one of csv, jsonl, mcap", None),
        (["-o", "x.yaml"], "cannot read x.yaml: No such file", None),
    ],
)
def test_mistakes_of_the_command_line(whole: Path, words, text, hint, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError, match=text) as caught:
        convert(whole, *words)
    assert hint is None or hint in caught.value.hint
    assert not Path("x").exists()


@pytest.mark.parametrize(
    ("words", "text", "hint"),
    [
        (["--topics", "/aa"], "there is no topic /aa in", "did you mean '/a'"),
        (["--remap", "/z:=/y"], "there is no topic /z in", "topics: /a, /b"),
        (["-e", "zzz"], "no topic is selected", "/a, /b"),
        (["--start", "5", "--end", "3"], "the end .* is not after the start", None),
    ],
)
def test_selections_of_nothing(tmp_path: Path, whole: Path, words, text, hint):
    with pytest.raises(BagError, match=text) as caught:
        convert(whole, "-o", tmp_path / "x", *words)
    assert hint is None or hint in caught.value.hint
    assert not (tmp_path / "x").exists()


def test_nothing_is_overwritten(tmp_path: Path, whole: Path):
    for name in ("x", "x.csv", "x.mcap"):
        (tmp_path / name).write_text("mine")
        with pytest.raises(BagError, match="exists already"):
            convert(whole, "-o", tmp_path / name)
        assert (tmp_path / name).read_text() == "mine"


def test_times_without_messages_are_told(tmp_path: Path, whole: Path, capsys):
    convert(whole, "-o", tmp_path / "x", "--start", "60")
    assert "0 messages of 2 topics (there is none in the selected time)" in capsys.readouterr().out
    assert contents(tmp_path / "x") == []


def test_a_damaged_input_leaves_no_output(tmp_path: Path):
    folder = write_bag(tmp_path / "b", counting("/a", 95))
    storage = folder / "b_0.mcap"
    damaged = bytearray(storage.read_bytes())
    damaged[800:900] = bytes(100)
    storage.write_bytes(bytes(damaged))
    for name in ("x", "x.mcap", "x.jsonl"):
        with pytest.raises(BagError, match="is damaged"):
            convert(folder, "-o", tmp_path / name)
        assert not (tmp_path / name).exists()


def test_an_unfinished_input_is_copied_as_far_as_it_goes(tmp_path: Path, capsys):
    folder = write_bag(tmp_path / "b", counting("/a", 95))
    storage = folder / "b_0.mcap"
    storage.write_bytes(storage.read_bytes()[: storage.stat().st_size // 2])
    convert(folder, "-o", tmp_path / "x")
    assert "bag check --repair" in capsys.readouterr().err
    found = numbers(tmp_path / "x")
    assert found == list(range(len(found)))
    assert 10 <= len(found) < 95


@pytest.mark.parametrize("name", ["x", "x.mcap", "x.jsonl"])
def test_a_full_disk_is_one_sentence(tmp_path: Path, name: str):
    noise = [message("/a", n, f"{n * 7919 % 10007:0>500}") for n in range(500)]
    folder = write_bag(tmp_path / "b", noise)

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))

    done = subprocess.run(
        [sys.executable, "-B", "-m", "launcher", "bag", "convert", folder, "-o", tmp_path / name],
        preexec_fn=limit,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert done.stderr == f"error: cannot write {tmp_path / name}: File too large\n"
    assert not (tmp_path / name).exists()


def test_the_options_of_ros2_bag_convert(tmp_path: Path, whole: Path):
    (tmp_path / "o.yaml").write_text(YAML.format(folder=tmp_path))
    convert("-i", whole, "mcap", "-o", tmp_path / "o.yaml")
    assert numbers(tmp_path / "one") == list(range(100))
    assert len(Bag(str(tmp_path / "one")).files) == 5
    assert contents(tmp_path / "two") == [("/b", f"message {n}") for n in range(5, 10)]
    assert metadata.read(str(tmp_path / "two")).compression_mode == "file"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[", "o.yaml:2: invalid YAML: "),
        ("{}", "has no list 'output_bags'"),
        ("output_bags: []", "has no list 'output_bags'"),
        ("output_bags: [x]", "output_bags, entry 1: it is not a mapping"),
        ("output_bags: [{topics: [a]}]", "entry 1: 'uri' is missing"),
        ("output_bags: [{uri: x, topcs: [a]}]", "entry 1: unknown key 'topcs'"),
        ("output_bags: [{uri: x, topics: a}]", "entry 1: topics: 'a' is not a list of texts"),
        ("output_bags: [{uri: x, storage_id: sqlite3}]", "storage_id: 'sqlite3' cannot be written"),
        ("output_bags: [{uri: x, max_bagfile_size: -1}]", "'-1' is not a whole number"),
        ("output_bags: [{uri: x, regex: '('}]", "is not a regular expression"),
        ("output_bags: [{uri: x}, {uri: x}]", "entry 2: 'x' is another entry's uri, too"),
        ("output_bags: [{uri: x, compression_mode: all}]", "is not one of none, file, message"),
    ],
)
def test_mistakes_of_its_options(tmp_path: Path, whole: Path, text: str, expected: str):
    (tmp_path / "o.yaml").write_text(text)
    with pytest.raises(UsageError, match=expected):
        convert(whole, "-o", tmp_path / "o.yaml")


def test_other_options_go_into_that_file(tmp_path: Path, whole: Path):
    (tmp_path / "o.yaml").write_text(YAML.format(folder=tmp_path))
    with pytest.raises(UsageError, match=r"--remap goes into .*o.yaml"):
        convert(whole, "-o", tmp_path / "o.yaml", "--remap", "/a:=/c")


def test_no_bag_is_named():
    with pytest.raises(LauncherError, match="no bag to read was named"):
        convert("-o", "x")


def test_the_oldest_text_is_kept(tmp_path: Path):
    folder = write_bag(tmp_path / "b", [Message("/a", 5, 3, 7, string_cdr("ü\n"))])
    convert(folder, "-o", tmp_path / "c")
    assert list(Bag(str(tmp_path / "c")).messages()) == [Message("/a", 5, 3, 7, string_cdr("ü\n"))]


def test_bags_to_read_and_their_times_in_a_file(tmp_path: Path, whole: Path):
    other = write_bag(tmp_path / "other", counting("/c", 5))
    file = tmp_path / "in.yaml"
    file.write_text(
        f"input_bags:\n- uri: {whole}\n  storage_id: mcap\n  end_time_ns: {START_NS + 10**8}\n"
        f"- {{uri: {other}, start_time_ns: {START_NS + 3 * 10**8}, end_time_ns: -1}}\n"
    )
    convert("--input-options", file, "-o", tmp_path / "one")
    assert [(topic, int(text.split()[1])) for topic, text in contents(tmp_path / "one")] == [
        ("/a", 0),
        ("/b", 0),
        ("/a", 1),  # the last time belongs to it
        ("/b", 1),
        ("/c", 3),
        ("/c", 4),
    ]
    (tmp_path / "out.yaml").write_text(YAML.format(folder=tmp_path / "x"))
    (tmp_path / "x").mkdir()
    convert("--input-options", file, "-o", tmp_path / "out.yaml")
    assert {topic for topic, _ in contents(tmp_path / "x" / "one")} == {"/a", "/c"}


def test_a_part_of_an_input_may_have_no_message(tmp_path: Path, whole: Path, capsys):
    file = tmp_path / "in.yaml"
    file.write_text(f"input_bags: [{{uri: {whole}, start_time_ns: {START_NS + 10**12}}}]")
    words = ("--exclude-topics", "/none", "a")
    convert("--input-options", file, "-o", tmp_path / "out", *words)
    out, err = capsys.readouterr()
    assert "0 messages of 1 topic (there is none in the selected time)" in out
    assert err == "warning: /none is not in what is read\n"


@pytest.mark.parametrize(
    ("text", "words", "error"),
    [
        ("input_bags: []", [], "in.yaml has no list 'input_bags'"),
        ("input_bags: [{storage_id: mcap}]", [], "input_bags, entry 1: 'uri' is missing"),
        ("input_bags: [{uri: a, start: 1}]", [], "entry 1: unknown key 'start'"),
        ("input_bags: [{uri: a}]\ninput_bag: 1", [], "in.yaml: unknown key 'input_bag'"),
        (
            "input_bags: [{uri: a, start_time_ns: 9, end_time_ns: 8}]",
            [],
            "entry 1: end_time_ns is before start_time_ns",
        ),
        ("input_bags: [{uri: a, end_time_ns: x}]", [], "end_time_ns: 'x' is not a whole number"),
        ("input_bags: [{uri: a}]", ["a"], "bags are in .*in.yaml, or named; not both"),
        ("input_bags: [{uri: a}]", ["-i", "a"], "bags are in .*in.yaml, or named; not both"),
    ],
)
def test_mistakes_in_bags_to_read(tmp_path: Path, text: str, words: list[str], error: str):
    (tmp_path / "in.yaml").write_text(text)
    with pytest.raises(UsageError, match=error):
        convert(*words, "--input-options", tmp_path / "in.yaml", "-o", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_ring_of_files_of_an_output(tmp_path: Path, whole: Path):
    (tmp_path / "o.yaml").write_text(
        f"output_bags: [{{uri: {tmp_path}/o, max_bagfile_duration: 2, max_bag_files: 2}}]"
    )
    convert(whole, "-o", tmp_path / "o.yaml")
    assert len(list((tmp_path / "o").glob("*.mcap"))) == 2
    assert Bag(str(tmp_path / "o")).extent.end_ns == Bag(str(whole)).extent.end_ns
