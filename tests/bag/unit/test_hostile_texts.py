"""QoS profiles and metadata that no bag has, and YAML without bounds."""

from __future__ import annotations

from pathlib import Path

import pytest
from mcap.writer import Writer

from launcher.bag import check, metadata
from launcher.bag.bag_model import BagError
from launcher.bag.reader import Bag
from tests.bag.unit.damaged_files import repaired
from tests.support.bags import string_cdr


@pytest.mark.parametrize(
    "text", ["nonsense", "[1, 2]", "{a: b}", "- {depth: much}", "- {deadline: 5}", "[" * 50_000]
)
def test_qos_that_is_no_list_of_mappings_is_a_note(tmp_path: Path, text: str):
    path = tmp_path / "a.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        channel = writer.register_channel("/a", "cdr", schema, {"offered_qos_profiles": text})
        writer.add_message(channel, 1, string_cdr("x"), 0)
        writer.finish()
    bag = Bag(str(path))
    assert bag.notes[0].startswith("/a: its QoS profiles cannot be read: ")
    assert [len(list(bag.messages())), bag.topics[0].qos] == [1, ()]
    report = check.check(str(path))
    assert report.is_whole
    assert report.files[0].notes[0].startswith("/a: its QoS profiles cannot be read: ")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("message_count: 95", f"message_count: {2**64 - 1}"),
        ("nanoseconds_since_epoch: 1", "nanoseconds_since_epoch: 99"),
        ("nanoseconds: 9", "nanoseconds: -9"),
        ("name: /a", "name: [/a]"),
        ("name: /a", 'name: "\\uD800"'),
        ("reliability: reliable", "reliability: [[], []]"),
        ("version: 9", "version: new"),
        ("custom_data:", "custom_data: {a: &a [x, x], b: [*a, *a]}\n  was:"),
        ("- good_0.mcap", '- "a\\0b"'),
        ("- good_0.mcap", "- &a [*a]"),
    ],
)
def test_metadata_that_no_bag_has(folder: Path, old: str, new: str):
    path = folder / metadata.FILE
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(BagError) as caught:
        Bag(str(folder))
    assert str(path) in caught.value.message
    assert "bag check --repair" in (caught.value.hint or "")
    repaired(folder)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[" * 50_000, "more than 100 levels"),
        ("a: [" * 50_000, "more than 100 levels"),
        ("x: " + "9" * 100_000, "a number of more than 1000 characters"),
        ("[" + "x, " * (6 << 20) + "]", "it has more than 16 MiB"),
        (
            "\n".join([*(f"a{n}: &a{n} [{f'*a{n - 1}, ' * 10}]" for n in range(1, 9))]).replace(
                "*a0", "x"
            ),
            "more than 1000000 values",
        ),
    ],
)
def test_yaml_without_bounds(folder: Path, text: str, reason: str):
    (folder / metadata.FILE).write_text(text)
    with pytest.raises(BagError, match=reason):
        Bag(str(folder))
    repaired(folder)
