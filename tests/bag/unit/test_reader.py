"""Reading bags: order, spans, split and foreign bags."""

from __future__ import annotations

from pathlib import Path

import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode
from rosbags.typesys import Stores, get_typestore

from launcher.bag import check, metadata
from launcher.bag.bag_model import BagError, Span
from launcher.bag.mcap import file as mcap_file
from launcher.bag.reader import Bag
from launcher.bag.writer import Storage
from tests.support.bags import START_NS, counting, message, text_of, write_bag


def texts(bag: Bag, *words: object, **more: object) -> list[str]:
    return [text_of(one.data) for one in bag.messages(*words, **more)]


def test_the_order_is_that_of_times_also_across_chunks(tmp_path: Path, monkeypatch):
    times = [3, 1, 2, 8, 5, 0, 9, 4, 7, 6]
    bag = write_bag(tmp_path / "b", [message("/a", t, f"at {t}") for t in times], flush_every=2)
    monkeypatch.setattr(mcap_file, "scan", None)  # the summary is enough
    assert texts(Bag(str(bag))) == [f"at {t}" for t in range(10)]


def test_spans_and_topics(tmp_path: Path):
    messages = [*counting("/a", 20), message("/b", 0.55, "b")]
    bag = Bag(str(write_bag(tmp_path / "b", messages)))
    span = Span(START_NS + 500_000_000, START_NS + 700_000_000)
    assert texts(bag, None, span) == ["message 5", "b", "message 6"]
    assert texts(bag, ["/b"]) == ["b"]
    assert texts(bag, ["/none"]) == []


@pytest.mark.parametrize("storage", [Storage(max_duration_ns=10**9), Storage(max_bytes=1)])
def test_split_bags_are_one(tmp_path: Path, storage: Storage):
    folder = write_bag(tmp_path / "b", counting("/a", 35), storage=storage, flush_every=1)
    bag = Bag(str(folder))
    assert len(bag.files) >= 4
    assert texts(bag) == [f"message {n}" for n in range(35)]
    assert bag.extent.total == 35
    assert metadata.read(str(folder)).topics == bag.topics


def test_files_as_lyrical_names_them(tmp_path: Path):
    """The number comes first, and a time last: `10_b_2026_11_30-01_02_03.mcap`."""
    folder = write_bag(
        tmp_path / "b", counting("/a", 12, 1.0), storage=Storage(max_duration_ns=10**9)
    )
    listed = (folder / metadata.FILE).read_text()
    for number in range(11, -1, -1):
        old, new = f"b_{number}.mcap", f"{number}_b_2026_11_30-01_02_{30 - number:02}.mcap"
        (folder / old).rename(folder / new)
        listed = listed.replace(f" {old}\n", f" {new}\n")
    (folder / metadata.FILE).write_text(listed)
    numbers = [f"message {n}" for n in range(12)]
    assert texts(Bag(str(folder))) == numbers
    (folder / metadata.FILE).unlink()  # its recorder was killed
    bag = Bag(str(folder))
    assert [Path(file).name.partition("_")[0] for file in bag.files] == [*map(str, range(12))]
    assert texts(bag) == numbers


@pytest.mark.parametrize("version", [8, 9])
@pytest.mark.parametrize("plugin", list(StoragePlugin))
@pytest.mark.parametrize(
    "mode", [CompressionMode.NONE, CompressionMode.FILE, CompressionMode.MESSAGE]
)
def test_bags_of_another_library(tmp_path: Path, version, plugin, mode):
    folder = tmp_path / "theirs"
    store = get_typestore(Stores.ROS2_JAZZY)
    writer = Writer(folder, version=version, storage_plugin=plugin)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    kind = store.types["std_msgs/msg/String"]
    with writer:
        connection = writer.add_connection("/chatter", "std_msgs/msg/String", typestore=store)
        for n in range(50):
            data = store.serialize_cdr(kind(data=f"message {n}"), "std_msgs/msg/String")
            writer.write(connection, START_NS + n * 10**7, data)
    assert check.check(str(folder)).is_whole
    bag = Bag(str(folder))
    assert texts(bag) == [f"message {n}" for n in range(50)]
    assert (bag.extent.total, bag.notes) == (50, [])
    assert bag.topics[0].definition is not None
    assert bag.topics[0].definition.text.startswith("string data")
    assert bag.extent.start_ns == START_NS


def test_without_metadata_it_says_so(tmp_path: Path):
    folder = write_bag(tmp_path / "b", counting("/a", 5))
    (folder / metadata.FILE).unlink()
    bag = Bag(str(folder))
    assert len(texts(bag)) == 5
    assert "it has no metadata.yaml" in bag.notes[0]


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda path: None, "there is no bag at"),
        (lambda path: path.mkdir(), "there is no bag in"),
        (lambda path: path.write_text("x"), "is not a bag"),
    ],
)
def test_what_is_no_bag(tmp_path: Path, make, text: str):
    make(tmp_path / "b")
    with pytest.raises(BagError, match=text):
        Bag(str(tmp_path / "b"))


def test_a_missing_file_is_named(tmp_path: Path):
    folder = write_bag(tmp_path / "b", counting("/a", 5))
    (folder / "b_0.mcap").rename(folder / "c.mcap")
    with pytest.raises(BagError, match=r"b_0.mcap is missing"):
        Bag(str(folder))
    with pytest.raises(BagError, match="name its folder"):
        raise_hint(folder / metadata.FILE)


def raise_hint(path: Path) -> None:
    try:
        Bag(str(path))
    except BagError as error:
        raise BagError(str(error.hint)) from None
