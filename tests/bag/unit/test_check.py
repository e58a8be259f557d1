"""`bag check`: what a killed recorder leaves, and damaged files."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from launcher.bag import check, metadata
from launcher.bag.bag_model import BagError
from launcher.bag.writer import Storage
from tests.bag.unit.damaged_files import storage_of, texts
from tests.support.bags import counting, write_bag


def test_a_whole_bag(whole: Path):
    report = check.check(str(whole))
    assert report.is_whole
    assert report.extent.total == 95


@pytest.mark.parametrize("part", range(40))
def test_cut_off_anywhere_the_whole_chunks_are_readable_and_repair_makes_it_whole(
    whole: Path, tmp_path: Path, part: int
):
    folder = Path(shutil.copytree(whole, tmp_path / "good"))
    (folder / metadata.FILE).unlink()
    file = storage_of(folder)
    data = file.read_bytes()
    file.write_bytes(data[: max(60, len(data) * part // 40)])
    before = texts(folder)
    report = check.check(str(folder))
    assert not report.is_whole
    check.repair(report, "jazzy")
    assert check.check(str(folder)).is_whole
    assert texts(folder) == before == [f"message {n}" for n in range(len(before))]
    assert len(before) % 10 == 0 or len(before) == 95
    with Reader(folder) as reader:
        assert reader.message_count == len(before)
    with file.open("rb") as stream:
        assert len(list(make_reader(stream, validate_crcs=True).iter_messages())) == len(before)


@pytest.mark.parametrize("at", [0.2, 0.5, 0.8])
def test_a_damaged_chunk_is_left_out_and_the_file_kept(whole: Path, tmp_path: Path, at: float):
    folder = Path(shutil.copytree(whole, tmp_path / "good"))
    file = storage_of(folder)
    data = bytearray(file.read_bytes())
    position = data.index(b"\x28\xb5\x2f\xfd", int(len(data) * at * 0.6)) + 20
    data[position] ^= 0xFF
    file.write_bytes(data)
    report = check.check(str(folder))
    assert not report.is_whole
    assert "a chunk is damaged" in report.files[0].faults[0].text
    check.repair(report, "jazzy")
    assert check.check(str(folder)).is_whole
    assert len(texts(folder)) in (85, 90)
    assert (folder / f"{file.name}.damaged").read_bytes() == data
    with Reader(folder) as reader:
        assert len(list(reader.messages())) == len(texts(folder))


def test_the_summary_of_a_repaired_file_is_as_the_writers(whole: Path, tmp_path: Path):
    folder = Path(shutil.copytree(whole, tmp_path / "good"))
    file = storage_of(folder)
    with file.open("rb") as stream:
        before = make_reader(stream).get_summary()
    file.write_bytes(file.read_bytes()[:-8])
    check.repair(check.check(str(folder)), "jazzy")
    with file.open("rb") as stream:
        after = make_reader(stream).get_summary()
    assert vars(after) == vars(before)


@pytest.mark.parametrize("size", [0, 5, 8, 20])
def test_killed_before_it_wrote_anything(whole: Path, tmp_path: Path, size: int):
    folder = Path(shutil.copytree(whole, tmp_path / "good"))
    file = storage_of(folder)
    file.write_bytes(file.read_bytes()[:size])
    (folder / metadata.FILE).unlink()
    assert texts(folder) == []
    report = check.check(str(folder))
    assert not report.is_whole
    check.repair(report, "jazzy")
    assert check.check(str(folder)).is_whole
    with file.open("rb") as stream:
        assert make_reader(stream).get_header().profile == "ros2"


def test_metadata_that_do_not_fit(whole: Path, tmp_path: Path):
    folder = Path(shutil.copytree(whole, tmp_path / "good"))
    text = (folder / metadata.FILE).read_text()
    (folder / metadata.FILE).write_text(text.replace("message_count: 95", "message_count: 96"))
    report = check.check(str(folder))
    assert report.problems == ["metadata.yaml counts 96 messages, the files have 95"]
    (folder / metadata.FILE).write_text("nonsense: [")
    assert "cannot read" in check.check(str(folder)).problems[0]
    check.repair(check.check(str(folder)), "jazzy")
    assert check.check(str(folder)).is_whole
    assert metadata.read(str(folder)).extent.total == 95


@pytest.mark.parametrize("mode", ["message", "file"])
def test_compressed_by_rosbag2s_means(tmp_path: Path, mode: str):
    storage = Storage(mode=mode)
    folder = write_bag(tmp_path / "good", counting("/a", 30), storage=storage)
    assert check.check(str(folder)).is_whole
    (folder / metadata.FILE).unlink()
    check.repair(check.check(str(folder)), "jazzy")
    assert metadata.read(str(folder)).compression_mode == mode
    assert texts(folder) == [f"message {n}" for n in range(30)]


def test_no_bag(tmp_path: Path):
    with pytest.raises(BagError, match="there is no bag in"):
        check.check(str(tmp_path))
    (tmp_path / "x.mcap").write_bytes(b"no bag at all")
    report = check.check(str(tmp_path))
    assert report.files[0].faults[0].text == "it is not an MCAP file"
    with pytest.raises(BagError, match=r"is not an MCAP file|nothing in"):
        check.repair(report, "jazzy")
