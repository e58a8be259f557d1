"""Recordings that keep the newest files, and files that begin with the last messages of topics."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.bag import check, metadata
from launcher.bag import verbs as bag_verb
from launcher.bag.bag_model import Message
from launcher.bag.reader import Bag
from launcher.bag.ros import static_topics
from launcher.bag.ros.sinks import FileSink, Ring
from launcher.bag.writer import BagWriter, Storage
from launcher.base.errors import UsageError
from tests.support.bags import START_NS, agreed_counts, counting, message, string_topic, text_of

S = 10**9


def one_file_each(folder: Path, **storage: object) -> BagWriter:
    """A writer that begins a new file with each message that is a second later."""
    return BagWriter(str(folder), Storage(max_duration_ns=S, **storage))


def texts(path: Path) -> list[tuple[str, str]]:
    return [(one.topic, text_of(one.data)) for one in Bag(str(path)).messages()]


@pytest.mark.parametrize("mode", ["none", "file", "message"])
def test_the_newest_files_are_kept(tmp_path: Path, mode: str):
    folder = tmp_path / "bag"
    writer = one_file_each(folder, max_files=3, mode=mode)
    writer.add_topic(string_topic("/a"))
    sizes = []
    for one in counting("/a", 6, 1.0):
        writer.write(one)
        sizes.append(writer.total)
    writer.close()
    suffix = ".zstd" if mode == "file" else ""
    names = [f"bag_{n}.mcap{suffix}" for n in (3, 4, 5)]
    assert sorted(os.listdir(folder)) == [*names, metadata.FILE]
    found = metadata.read(str(folder))
    assert found is not None
    assert [file.path for file in found.files] == names
    assert (found.extent.start_ns, found.extent.total) == (START_NS + 3 * S, 3)
    assert sizes == [1, 2, 3, 3, 3, 3]
    assert [text for _, text in texts(folder)] == ["message 3", "message 4", "message 5"]
    assert len(writer.notes) == 3
    assert writer.notes[0].startswith(f"Deleted oldest bagfile: bag_0.mcap{suffix} (")
    assert writer.notes[0].endswith(" bytes, 0 ns)")
    assert check.check(str(folder)).is_whole
    if mode == "none":
        assert agreed_counts(folder) == {"/a": 3}


def test_a_file_that_cannot_be_removed_is_tried_again(tmp_path: Path, monkeypatch):
    writer = one_file_each(tmp_path / "bag", max_files=1)
    writer.add_topic(string_topic("/a"))
    first, second, third = counting("/a", 3, 1.0)
    with monkeypatch.context() as patch:
        patch.setattr(os, "unlink", refuse)
        writer.write(first)
        writer.write(second)
    assert writer.notes.popleft().endswith("bag_0.mcap: Operation not permitted")
    assert writer.total == 2
    writer.write(third)
    writer.close()
    assert [text for _, text in texts(tmp_path / "bag")] == ["message 2"]


def refuse(path: str) -> None:
    raise PermissionError(1, "Operation not permitted", path)


def test_each_further_file_begins_with_the_last_messages(tmp_path: Path):
    folder = tmp_path / "bag"
    writer = one_file_each(folder)
    for name in ("/map", "/tf_static", "/scan"):
        writer.add_topic(string_topic(name))
    writer.repeat("/map", 1)
    writer.repeat("/tf_static", 2)
    for one in (
        message("/map", 0.0, "old map"),
        *(message("/tf_static", 0.1 * n, f"tf {n}") for n in range(1, 4)),
        message("/map", 0.5, "map"),
        message("/scan", 0.6, "scan 0"),
        message("/scan", 1.6, "scan 1"),
    ):
        writer.write(one)
    writer.close()
    (second,) = folder.glob("*_1.mcap")
    assert texts(second) == [
        ("/tf_static", "tf 2"),
        ("/tf_static", "tf 3"),
        ("/map", "map"),
        ("/scan", "scan 1"),
    ]
    assert {one.log_ns for one in list(Bag(str(second)).messages())[:3]} == {
        START_NS + round(0.6 * S)
    }
    assert agreed_counts(folder) == {"/map": 3, "/tf_static": 5, "/scan": 2}


def test_contents_of_the_ring_begin_with_the_last_messages():
    ring = Ring(10**6, 1.0, clock_ns=None)
    ring.repeat("/map", 1)
    ring.put(message("/map", 0, "map"), b"p")
    assert len(ring.contents()) == 1  # it is there anyhow
    for one in (message("/scan", 5, "scan 0"), message("/scan", 5.5, "scan 1")):
        ring.put(one, b"p")
    ring.forget_old()
    found = [one for one, _ in ring.contents()]
    assert [(one.topic, one.log_ns - START_NS) for one in found] == [
        ("/map", 5 * S),
        ("/scan", 5 * S),
        ("/scan", round(5.5 * S)),
    ]
    ring.clear()
    assert ring.contents() == []
    ring.put(message("/scan", 9, "scan 2"), b"p")
    assert [text_of(one.data) for one, _ in ring.contents()] == ["map", "scan 2"]


class _Held(BagWriter):
    """Writes nothing."""

    def write(self, message: Message) -> None:
        raise OSError(28, "No space left on device")


def test_what_waits_is_bounded_by_time(tmp_path: Path):
    sink = FileSink(_Held(str(tmp_path / "bag")), 10**6, 2)
    taken = [sink.put(one, b"p") for one in counting("/a", 5, 1.0)]
    assert taken == [True, True, True, False, False]
    sink.finish()


def test_static_topics(tmp_path: Path):
    file = tmp_path / "topics.yaml"
    file.write_text(
        "static_topics_and_types_list:\n"
        " - [/scan, sensor_msgs/msg/LaserScan]\n"
        " - [map, nav_msgs/OccupancyGrid]\n"
    )
    assert static_topics.read(str(file)) == {
        "/scan": "sensor_msgs/msg/LaserScan",
        "/map": "nav_msgs/msg/OccupancyGrid",
    }


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("topics: []", "FILE has no list 'static_topics_and_types_list'"),
        (
            "static_topics_and_types_list: [[/a, std_msgs/msg/String], [/b]]",
            r"FILE: static_topics_and_types_list, entry 2: \['/b'\] is no topic with its type",
        ),
        ("static_topics_and_types_list: [/a]", "entry 1: '/a' is no topic with its type"),
        ("static_topics_and_types_list: [[/a, String]]", "is no topic with its type"),
        (
            "static_topics_and_types_list: [[/a, b/msg/C], [a, b/C], [/a, b/msg/D]]",
            "FILE: /a has two types, b/msg/C and b/msg/D",
        ),
    ],
)
def test_mistakes_in_static_topics(tmp_path: Path, text: str, error: str):
    file = tmp_path / "topics.yaml"
    file.write_text(text)
    with pytest.raises(UsageError, match=error.replace("FILE", str(file))):
        static_topics.read(str(file))


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["--snapshot-mode", "--max-cache-size", "0"], "memory needs a limit"),
        (["--max-cache-duration", "0.5"], "'0.5' is not a whole number from 0 to 4294967295"),
        (["--max-cache-duration", "4294967296"], "is not a whole number"),
        (["--max-bag-files", "-1"], "is not a whole number"),
        (["--repeat-transient-local", "/map=0"], "'0' is not a whole number from 1 to"),
        (["--repeat-transient-local", "bad name"], "Invalid topic name"),
        (["--repeat-all-transient-local", "-1"], "--repeat-all-transient-local: '-1' is not a"),
        (["--repeat-all-transient-local", "2.5"], "'2.5' is not a whole number"),
        (["--repeat-transient-local", "=3"], "'=3' is not TOPIC or TOPIC=DEPTH"),
        (["--static-topics-path", "/no/such.yaml"], "cannot read /no/such.yaml"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_mistakes_in_options_of_record(tmp_path: Path, words: list[str], error: str):
    with pytest.raises(UsageError) as caught:
        bag_verb.main(["record", "-a", "-o", str(tmp_path / "bag"), *words])
    assert error in str(caught.value)
    assert not (tmp_path / "bag").exists()


def test_types_of_static_topics_are_installed(tmp_path: Path, capsys, monkeypatch):
    monkeypatch.setattr("launcher.bag.ros.record_run.record", lambda *_: 0)
    file = tmp_path / "topics.yaml"
    words = ["record", "-o", str(tmp_path / "bag"), "--static-topics-path", str(file)]
    file.write_text("static_topics_and_types_list: [[/a, std_msgs/msg/Nope]]")
    with pytest.raises(UsageError, match=f"{file}: /a: The passed message type is invalid"):
        bag_verb.main(words)
    file.write_text("static_topics_and_types_list: [[/a, std_msgs/msg/String]]")
    assert bag_verb.main(words) == 0
    with pytest.raises(UsageError, match="nothing to record was named"):
        bag_verb.main([*words, "-x", "a"])
    assert capsys.readouterr().err == f"/a of {file} is excluded\n"


def test_a_ring_of_one_file_is_a_warning(tmp_path: Path, capsys, monkeypatch):
    monkeypatch.setattr("launcher.bag.ros.record_run.record", lambda *_: 0)
    words = ["record", "-a", "-o", str(tmp_path / "bag"), "--max-bag-files", "2"]
    assert bag_verb.main(words) == 0
    assert "--max-bag-files has no effect without -b or -d" in capsys.readouterr().err
    assert bag_verb.main([*words, "-b", "1M"]) == 0
    assert capsys.readouterr().err == ""
