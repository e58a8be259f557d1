"""`bag check`: is a bag whole, and makes it so."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from dataclasses import dataclass, field

from launcher.bag import compression, metadata
from launcher.bag.agreement import Agreement, contradiction
from launcher.bag.bag_model import BagError, ChannelTopic, Extent, Span, Topic, summed
from launcher.bag.mcap.file import parts_of
from launcher.bag.mcap.repair import append_summary, rewrite
from launcher.bag.mcap.scan import McapFault, scan
from launcher.bag.metadata import File, Metadata
from launcher.bag.reader import check_storage, open_storage, storage_files

MCAP, COMPRESSED = ".mcap", ".zstd"


@dataclass(slots=True)
class FileReport:
    """What a storage file has, and what is wrong with it. A topic may have several channels.

    `notes` are about topics, of whole bytes. `conflicts` say which messages are of another type
    than their topic, so that other verbs leave them out; the extent has them.
    """

    path: str
    topics: list[Topic]
    extent: Extent
    faults: list[McapFault]
    notes: list[str] = field(default_factory=list)
    conflicts: list[str] = field(default_factory=list)

    @property
    def name(self) -> str:
        return os.path.basename(self.path)

    @property
    def loses(self) -> bool:
        """Whether data are damaged, as opposed to an end that is missing."""
        return any(fault.lost for fault in self.faults)

    @property
    def is_whole(self) -> bool:
        return not self.faults

    @property
    def is_repairable(self) -> bool:
        return bool(self.faults) and self.path.endswith(MCAP) and self.has_data

    @property
    def has_data(self) -> bool:
        """Whether there is anything of a bag in it, or it was just begun."""
        return bool(self.topics) or not self.loses


@dataclass(slots=True)
class BagReport:
    """What `check` found. `problems` are those of `metadata.yaml`.

    A repair does not change conflicts: that would be a choice of what to remove.
    """

    path: str
    files: list[FileReport]
    problems: list[str]

    @property
    def is_whole(self) -> bool:
        return not self.is_damaged and not any(file.conflicts for file in self.files)

    @property
    def is_damaged(self) -> bool:
        """Whether it is not whole for another reason than conflicts."""
        return bool(self.problems) or not all(file.is_whole for file in self.files)

    @property
    def is_repairable(self) -> bool:
        """Whether a repair would change anything, and is possible."""
        broken = (file for file in self.files if not file.is_whole)
        return self.is_damaged and all(file.is_repairable for file in broken)

    @property
    def extent(self) -> Extent:
        return summed(file.extent for file in self.files)


def check(path: str) -> BagReport:
    """Read every byte of a bag. BagError if there is none, OSError."""
    if not os.path.isdir(path):
        if not os.path.exists(path):
            raise BagError(f"there is no bag at {path}")
        return BagReport(path, [_check_file(path, Agreement())], [])
    names = storage_files(path)
    if not names:
        raise BagError(f"there is no bag in {path}", hint="it has no .mcap and no .db3 file")
    agreement = Agreement()
    files = [_check_file(os.path.join(path, name), agreement) for name in names]
    return BagReport(path, files, list(_check_metadata(path, files)))


def _check_file(path: str, agreement: Agreement) -> FileReport:
    check_storage(path)
    if path.endswith(MCAP):
        with open(path, "rb") as stream:
            found = scan(stream)
        notes: list[str] = []
        parts = parts_of(found.channels, found.schemas, found.counts, notes)
        topics, conflicts = _agreed(parts, agreement)
        return FileReport(path, topics, found.extent, found.faults, notes, conflicts)
    try:
        file = open_storage(path)
    except BagError as error:
        return FileReport(path, [], Extent(), [McapFault(0, error.message)])
    with contextlib.closing(file):
        faults = [McapFault(0, file.unfinished, lost=False)] if file.unfinished else []
        topics, conflicts = _agreed(file.parts, agreement)
        return FileReport(path, topics, file.extent, faults, file.notes, conflicts)


def _agreed(parts: list[ChannelTopic], agreement: Agreement) -> tuple[list[Topic], list[str]]:
    """The topics of the channels that agree, and sentences on the others."""
    others = agreement.take(parts)
    return [part.topic for part in parts if part.key not in others.keys], others.notes


def _check_metadata(folder: str, files: list[FileReport]) -> Iterator[str]:
    try:
        listed = metadata.read(folder)
    except BagError as error:
        yield error.message
        return
    if listed is None:
        yield f"{metadata.FILE} is missing: the recorder did not finish the bag"
        return
    there = {file.name for file in files}
    names = {os.path.basename(file.path) for file in listed.files}
    for name in sorted(names - there):
        yield f"{metadata.FILE} lists {name}, which is missing"
    for name in sorted(there - names):
        yield f"{metadata.FILE} does not list {name}"
    counted = summed(file.extent for file in files).total
    if names == there and listed.extent.total != counted:
        yield f"{metadata.FILE} counts {listed.extent.total} messages, the files have {counted}"
    for file in files:
        yield from _check_topics(listed, file)


def _check_topics(listed: Metadata, file: FileReport) -> Iterator[str]:
    """Types and QoS: the library `rosbags` reads only what has the same QoS in both."""
    for name, count in file.extent.counts.items():
        known = [one for one in listed.topics if one.name == name]
        own = [one for one in file.topics if one.name == name]
        if not known or not own or not count:
            continue
        texts = [contradiction(one, other) for one in known for other in own]
        if (text := texts[0]) and all(texts):
            yield text
        elif any(list(one.qos) not in [list(other.qos) for other in known] for one in own):
            yield (
                f"{metadata.FILE} has other QoS of {name} than {file.name}, so that some readers "
                "leave out its messages (bag convert writes a bag that has all)"
            )


def repair(report: BagReport, ros_distro: str) -> list[str]:
    """Make a bag whole as far as it can be; what was done, a sentence for each.

    BagError for what cannot be repaired, OSError.
    """
    done = []
    for file in report.files:
        if not file.is_whole:
            done.append(_repair_file(file))
    if os.path.isdir(report.path):
        _write_metadata(report, ros_distro)
        done.append(f"{metadata.FILE}: written anew, {report.extent.total} messages")
    return done


def _repair_file(file: FileReport) -> str:
    if not file.path.endswith(MCAP):
        raise BagError(f"{file.name} cannot be repaired: {file.faults[0].text}")
    size = os.path.getsize(file.path)
    if not file.loses:
        file.extent = append_summary(file.path)
        return (
            f"{file.name}: finished, {file.extent.total} messages "
            f"({size} bytes before, {os.path.getsize(file.path)} after)"
        )
    damaged = _unused(f"{file.path}.damaged")
    file.extent = rewrite(file.path, damaged)
    kept = os.path.basename(damaged)
    return f"{file.name}: {file.extent.total} messages are whole; the damaged file is {kept}"


def _unused(path: str) -> str:
    number, found = 1, path
    while os.path.exists(found):
        number += 1
        found = f"{path}.{number}"
    return found


def _write_metadata(report: BagReport, ros_distro: str) -> None:
    try:
        old = metadata.read(report.path)
    except BagError:
        old = None
    topics: dict[str, Topic] = {}
    for topic in (topic for file in report.files for topic in file.topics):
        topics.setdefault(topic.name, topic)
    mode = _mode(report, old)
    metadata.write(
        report.path,
        Metadata(
            storage="mcap" if MCAP in report.files[0].name else "sqlite3",
            topics=list(topics.values()),
            files=[File(path=file.name, extent=file.extent) for file in report.files],
            extent=report.extent,
            compression_format="zstd" if mode else "",
            compression_mode=mode,
            ros_distro=old.ros_distro if old is not None else ros_distro,
            custom_data=old.custom_data if old is not None else {},
        ),
    )


def _mode(report: BagReport, old: Metadata | None) -> str:
    """How rosbag2 compressed: of a killed recorder only the files show it."""
    if report.files[0].name.endswith(COMPRESSED):
        return "file"
    if old is not None:
        return old.compression_mode
    for file in report.files:
        with contextlib.closing(open_storage(file.path)) as opened:
            for message in opened.messages(None, Span()):
                return "message" if compression.is_compressed(message.data) else ""
    return ""
