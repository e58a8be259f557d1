"""Writes bags: a folder with MCAP files, as rosbag2's storage plugin for MCAP does."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from launcher.bag import compression, metadata
from launcher.bag.bag_model import (
    LAST_NS,
    ROS2_MSG,
    BagError,
    Definition,
    Extent,
    Message,
    Qos,
    Topic,
    summed,
)
from launcher.bag.mcap.output import McapStream
from launcher.bag.mcap.repair import append_summary, drop_chunks
from launcher.bag.metadata import File, Metadata

CHUNK_BYTES = 1024 * 1024
_METADATA_NAME = "rosbag2"


@dataclass(frozen=True, slots=True, kw_only=True)
class Storage:
    """How files are written. `mode` compresses by rosbag2's means, besides the chunks.

    A new file begins after `max_bytes`, or `max_duration_ns`; 0 is never. Of the files, the last
    `max_files` are kept; 0 is all.
    """

    chunk_compression: str = "zstd"
    mode: str = "none"
    format: str = "zstd"
    max_bytes: int = 0
    max_duration_ns: int = 0
    max_files: int = 0


class BagWriter:
    """A new bag. BagError if `folder` exists; OSError if writing fails.

    A topic has the same QoS in `metadata.yaml` and in each file, since some readers leave out the
    messages of one that differs. In a file it cannot change once the channel is written, which is
    with the first message of the topic.

    `notes` gets a sentence for each file that is removed, `splits` each file that is finished with
    the next one.
    """

    def __init__(
        self,
        folder: str,
        storage: Storage | None = None,
        *,
        ros_distro: str = "",
        custom_data: Mapping[str, str] | None = None,
    ) -> None:
        self.folder = folder
        self.notes: deque[str] = deque()
        self.splits: deque[tuple[str, str]] = deque()
        self._storage = storage or Storage()
        self._ros_distro = ros_distro
        self._custom_data = dict(custom_data or {})
        self._topics: dict[str, Topic] = {}
        self._begun: set[str] = set()  # topics that have a channel in a file
        self._files: list[File] = []
        self._number = 0  # of files that were begun
        self._latched = LastMessages()
        self._last: Message | None = None
        self._compress = (
            compression.message_compressor() if self._storage.mode == "message" else None
        )
        try:
            os.makedirs(folder)
        except FileExistsError:
            raise BagError(
                f"{folder} exists already", hint="name another folder with -o, or remove this one"
            ) from None
        self._file = self._new_file()

    def _new_file(self) -> McapOutput:
        name = os.path.basename(os.path.abspath(self.folder))
        path = os.path.join(self.folder, f"{name}_{self._number}.mcap")
        try:
            file = McapOutput(path, self._storage)
        except OSError:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(path)
            raise
        self._number += 1
        for topic in self._topics.values():
            file.add_topic(topic)
        return file

    @property
    def path(self) -> str:
        """The file that is being written."""
        return self._file.path

    @property
    def size_bytes(self) -> int:
        """What the files take, without what is not written yet."""
        finished = [os.path.join(self.folder, file.path) for file in self._files]
        begun = 0 if self._file.closed else self._file.size_bytes
        return begun + sum(map(os.path.getsize, finished))

    @property
    def total(self) -> int:
        """The number of messages."""
        begun = 0 if self._file.closed else self._file.extent.total
        return begun + sum(file.extent.total for file in self._files)

    def add_topic(self, topic: Topic) -> None:
        self._topics.setdefault(topic.name, topic)

    def set_qos(self, topic: str, profiles: Sequence[Qos]) -> None:
        """What its publishers offer by now; without effect once a file has the channel."""
        if topic not in self._begun:
            self._topics[topic] = replace(self._topics[topic], qos=profiles)

    def repeat(self, topic: str, depth: int) -> None:
        """Write the last messages of a topic again at the begin of each further file."""
        self._latched.keep(topic, depth)

    def _begin(self, topic: str) -> None:
        self._file.add_topic(self._topics[topic])
        self._begun.add(topic)

    def write(self, message: Message) -> None:
        """Add a message of a topic that was added. OSError."""
        if self._is_full(message.log_ns):
            self.split()
        if message.topic not in self._begun:
            self._begin(message.topic)
        if self._compress is not None:
            message = message._replace(data=self._compress(message.data))
        self._file.write(message)
        self._latched.add(message)
        self._last = message

    def _is_full(self, log_ns: int) -> bool:
        storage, extent = self._storage, self._file.extent
        if not extent.counts:
            return False
        too_long = 0 < storage.max_duration_ns <= log_ns - extent.start_ns
        return too_long or 0 < storage.max_bytes <= self._file.size_bytes

    def split(self) -> None:
        """Finish the file and begin the next one."""
        self._finish_file()
        self._file = self._new_file()
        closed = os.path.join(self.folder, self._files[-1].path)
        self.splits.append((closed, self._file.path))
        self._remove_oldest()
        if self._last is not None:  # with its times: those of a file are times of its recording
            for message in self._latched.at(self._last.log_ns, self._last.publish_ns):
                self._file.write(message)

    def _remove_oldest(self) -> None:
        """A file that cannot be removed stays in the metadata, and is tried again."""
        while 0 < self._storage.max_files < len(self._files) + 1:
            file = self._files[0]
            path = os.path.join(self.folder, file.path)
            try:
                size = os.path.getsize(path)
                os.unlink(path)
            except FileNotFoundError:
                self.notes.append(f"{path} was removed by another program")
            except OSError as error:
                self.notes.append(f"cannot remove {path}: {error.strerror}")
                return
            else:
                duration = file.extent.duration_ns
                self.notes.append(
                    f"Deleted oldest bagfile: {file.path} ({size} bytes, {duration} ns)"
                )
            del self._files[0]

    def flush(self) -> None:
        """Write what has been added, so that it can be read if this process is killed. OSError."""
        self._file.flush()

    def _finish_file(self) -> None:
        file = self._file
        for topic in self._topics:
            if topic not in self._begun:
                self._begin(topic)
        file.finish(metadata.to_yaml(self._metadata([*self._files, file.entry]), root=False))
        path = file.path
        if self._storage.mode == "file":
            path = compression.compress_file(path, self._storage.format)
        self._files.append(File(path=os.path.basename(path), extent=file.extent))

    def _metadata(self, files: Sequence[File]) -> Metadata:
        compressed = self._storage.mode != "none"
        return Metadata(
            storage="mcap",
            topics=list(self._topics.values()),
            files=files,
            extent=summed(file.extent for file in files),
            compression_format=self._storage.format if compressed else "",
            compression_mode=self._storage.mode if compressed else "",
            ros_distro=self._ros_distro,
            custom_data=self._custom_data,
        )

    def close(self) -> Metadata:
        """Finish the last file and write `metadata.yaml`. OSError."""
        self._finish_file()
        found = self._metadata(self._files)
        metadata.write(self.folder, found)
        return found

    def rescue(self) -> None:
        """After an OSError: make a whole bag of what was written; OSError if that fails, too.

        On a full disk the last chunks are dropped, as many as the end of the bag needs room.
        """
        self._file.abandon()
        names = [file.path for file in self._files]
        begun = os.path.basename(self._file.path)
        if begun not in names and os.path.exists(self._file.path):
            names.append(begun)
        number = 1
        while True:
            try:
                self._finish_rescued(names)
                return
            except OSError:
                if not self._make_room(names, number):
                    raise
            number *= 2  # each time, the file is read

    def _finish_rescued(self, names: Sequence[str]) -> None:
        """Write the end of the last file, and `metadata.yaml`. OSError."""
        files = {file.path: file for file in self._files}
        last = names[-1]
        if last.endswith(".mcap"):
            extent = append_summary(os.path.join(self.folder, last))
            files[last] = File(path=last, extent=extent)
        self._files = [files[name] for name in names]
        metadata.write(self.folder, self._metadata(self._files))

    def _make_room(self, names: list[str], number: int) -> bool:
        """Drop the last chunks, or a last file without any; whether there was something to drop."""
        path = os.path.join(self.folder, names[-1])
        if path.endswith(".mcap") and drop_chunks(path, number):
            return True
        if len(names) < 2:
            return False
        os.unlink(path)
        del names[-1]
        return True

    def discard(self) -> None:
        """Remove the bag, whatever it has."""
        self._file.abandon()
        shutil.rmtree(self.folder, ignore_errors=True)


class LastMessages:
    """The last messages of some topics."""

    def __init__(self) -> None:
        self._messages: dict[str, deque[Message]] = {}

    def keep(self, topic: str, depth: int) -> None:
        self._messages[topic] = deque(maxlen=depth)

    def add(self, message: Message) -> None:
        if (kept := self._messages.get(message.topic)) is not None:
            kept.append(message)

    def before(self, log_ns: int) -> list[Message]:
        """Those received before this time, oldest first."""
        found = [one for kept in self._messages.values() for one in kept if one.log_ns < log_ns]
        return sorted(found, key=lambda one: one.log_ns)

    def at(self, log_ns: int, publish_ns: int) -> list[Message]:
        """All, oldest first, with these times."""
        found = self.before(LAST_NS)
        return [one._replace(log_ns=log_ns, publish_ns=publish_ns) for one in found]


class McapOutput:
    """One MCAP file being written."""

    def __init__(self, path: str, storage: Storage) -> None:
        self.path = path
        self.extent = Extent()
        self._channels: dict[str, int] = {}
        self._schemas: dict[tuple[str, Definition | None], int] = {}
        chunk_bytes = CHUNK_BYTES
        if storage.max_bytes:
            chunk_bytes = min(chunk_bytes, max(storage.max_bytes // 8, 1024))
        # from now on it can be read
        self._stream = McapStream(
            path,
            chunk_bytes,
            storage.chunk_compression,
            is_read_next=storage.mode == "file",  # it is compressed as a whole
        )

    @property
    def closed(self) -> bool:
        return self._stream.closed

    @property
    def size_bytes(self) -> int:
        return self._stream.size_bytes

    @property
    def entry(self) -> File:
        return File(path=os.path.basename(self.path), extent=self.extent)

    def add_topic(self, topic: Topic) -> None:
        definition = topic.definition
        schema = self._schemas.get((topic.type, definition))
        if schema is None:
            schema = self._schemas[topic.type, definition] = self._stream.add_schema(
                topic.type,
                definition.encoding if definition else ROS2_MSG,
                definition.text.encode("utf-8", "surrogateescape") if definition else b"",
            )
        self._channels[topic.name] = self._stream.add_channel(
            topic.name,
            topic.serialization,
            schema,
            {
                "offered_qos_profiles": metadata.qos_text(topic.qos) if topic.qos else "",
                "topic_type_hash": topic.type_hash,
            },
        )

    def write(self, message: Message) -> None:
        self.extent.add(message.topic, message.log_ns)
        self._stream.add_message(
            self._channels[message.topic],
            message.log_ns,
            message.publish_ns,
            message.sequence & 0xFFFFFFFF,
            message.data,
        )

    def flush(self) -> None:
        self._stream.flush()

    def finish(self, metadata_text: str) -> None:
        self._stream.add_metadata(_METADATA_NAME, {"serialized_metadata": metadata_text})
        self._stream.finish()

    def abandon(self) -> None:
        """Close the file with whatever has reached it."""
        self._stream.abandon()
