"""Opens bags: folders of rosbag2 and of the launcher, or single storage files."""

from __future__ import annotations

import bisect
import contextlib
import functools
import heapq
import itertools
import operator
import os
import re
import stat
from array import array
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from launcher.bag import compression, metadata
from launcher.bag.agreement import Agreement, contradiction, normalized
from launcher.bag.bag_model import (
    BagError,
    Extent,
    Message,
    Span,
    TimesBlock,
    Topic,
    merged,
    never,
    summed,
)
from launcher.base import text_file

if TYPE_CHECKING:
    from launcher.bag.mcap.file import McapFile
    from launcher.bag.sqlite_file import SqliteFile

_ENDINGS = (".mcap", ".db3")
_SUFFIX = ".zstd"
_EVERYTHING = Span()
_USUAL_TIMES = 20_000  # of messages that wait for others of a bag


class Bag:
    """A bag, for reading. `notes` say what is unusual about it.

    A topic has one type, definition and encoding: messages with another one are left out, and
    `left_out` counts them.

    BagError if there is no bag at `path`, or one of its files cannot be read. Files are opened when
    they are needed.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self.notes: list[str] = []
        self.metadata = metadata.read(path) if os.path.isdir(path) else None
        self.files = self._find_files()
        if self.metadata is not None:
            compression.check_format(self.metadata.compression_format)
        self.left_out: dict[str, int] = {}
        self._agreement = Agreement()
        self._known: dict[str, tuple[list[Topic], Extent]] = {}
        self.topics = self._topics()
        self.extent = summed(self.summary_of(path)[1] for path in self.files)

    def _find_files(self) -> list[str]:
        if not os.path.isdir(self.path):
            return [_storage_file(self.path)]
        if self.metadata is not None:
            return [self._listed(file.path) for file in self.metadata.files]
        found = storage_files(self.path)
        if not found:
            raise BagError(
                f"there is no bag in {self.path}",
                hint="a bag is a folder with metadata.yaml and .mcap or .db3 files, or such a file",
            )
        self.notes.append(
            f"it has no {metadata.FILE}: its recorder did not finish it "
            f"(bag check --repair {self.path} writes one)"
        )
        return [os.path.join(self.path, name) for name in found]

    def _listed(self, path: str) -> str:
        """A file of the metadata, which in early versions is relative to the folder's parent."""
        for name in (path, os.path.basename(path)):
            if os.path.exists(full := os.path.join(self.path, name)):
                return full
        raise BagError(
            f"{os.path.join(self.path, path)} is missing, which {metadata.FILE} lists",
            hint=f"to list only the files that are there: bag check --repair {self.path}",
        )

    @property
    def size_bytes(self) -> int:
        return sum(os.path.getsize(path) for path in self.files)

    @property
    def storage(self) -> str:
        return "sqlite3" if ".db3" in os.path.basename(self.files[0]) else "mcap"

    @functools.cached_property
    def compresses_messages(self) -> bool:
        """Whether each message is compressed; without metadata, as the first one shows."""
        if self.metadata is not None:
            return self.metadata.compression_mode == "message"
        for path in self.files:
            with self._opened(path) as file:
                for message in file.messages(None, Span()):
                    return compression.is_compressed(message.data)
        return False

    def topic(self, name: str) -> Topic | None:
        return next((topic for topic in self.topics if topic.name == name), None)

    def _topics(self) -> list[Topic]:
        """Of all files, with the definitions that they have; QoS as the metadata say."""
        found: dict[str, Topic] = {}
        if self.metadata is not None:
            found = {topic.name: topic for topic in merged(self.metadata.topics)}
        for topic in [topic for path in self.files for topic in self.summary_of(path)[0]]:
            if self._agreement.difference(topic):  # that of a file without its messages
                continue
            known = found.get(topic.name)
            if self.metadata and known and (note := contradiction(known, topic)):
                self.notes.append(note)
                known = None
            if known is None:
                found[topic.name] = topic
            elif known.definition is None:
                found[topic.name] = replace(
                    known,
                    serialization=topic.serialization,
                    definition=topic.definition,
                    type_hash=known.type_hash or topic.type_hash,
                    qos=known.qos or topic.qos,
                )
        return [normalized(topic) for topic in found.values()]

    def summary_of(self, path: str) -> tuple[list[Topic], Extent]:
        """The topics and the extent of one of the files."""
        if path not in self._known:
            with self._opened(path) as file:
                self._known[path] = file.topics, file.extent
                others = self._agreement.take(file.parts)
                for topic, number in others.counts.items():
                    self.left_out[topic] = self.left_out.get(topic, 0) + number
                notes = [*file.notes, *others.notes]
                if file.unfinished:
                    notes.append(
                        f"{file.unfinished} (bag check --repair {self.path} makes it whole)"
                    )
                # A bag that is a file is named where the notes are printed.
                where = "" if path == self.path else f"{os.path.basename(path)}: "
                self.notes += [f"{where}{note}" for note in notes]
        return self._known[path]

    @contextlib.contextmanager
    def _opened(self, path: str) -> Iterator[McapFile | SqliteFile]:
        try:
            file = open_storage(path)
        except OSError as error:
            raise BagError(f"cannot read {path}: {error.strerror or error}") from None
        with contextlib.closing(file):
            file.leave_out(self._agreement.take(file.parts).keys)
            yield file

    def messages(
        self,
        topics: Iterable[str] | None = None,
        span: Span = _EVERYTHING,
        stopped: Callable[[], bool] = never,
    ) -> Iterator[Message]:
        """The messages of these topics (None: of all) in the order of their times. BagError.

        They end early if `stopped`, which is asked now and then, says so.
        """
        chosen = None if topics is None else frozenset(topics)
        parts = [(self.summary_of(path)[1], path) for path in self.files]
        parts = [part for part in parts if part[0].counts and _overlaps(part[0], span)]
        parts.sort(key=lambda part: part[0].start_ns)
        streams = [self._of_file(path, chosen, span, stopped) for _, path in parts]
        if any(a[0].end_ns > b[0].start_ns for a, b in itertools.pairwise(parts)):
            yield from heapq.merge(*streams, key=lambda message: message.log_ns)
            return
        for stream in streams:
            yield from stream

    def times(self) -> Iterator[tuple[str, array[int]]]:
        """The times of the messages, as `TopicTimes` takes them. BagError.

        It takes no more than the indexes where a file has them.
        """
        return _in_order(
            (self.summary_of(path)[1].start_ns, self._times_of(path)) for path in self.files
        )

    def _times_of(self, path: str) -> Iterator[TimesBlock]:
        with self._opened(path) as file:
            yield from file.times()

    def _of_file(
        self,
        path: str,
        topics: frozenset[str] | None,
        span: Span,
        stopped: Callable[[], bool],
    ) -> Iterator[Message]:
        with self._opened(path) as file:
            if not self.compresses_messages:
                yield from file.messages(topics, span, stopped)
                return
            decompress = compression.message_decompressor()
            for message in file.messages(topics, span, stopped):
                try:
                    yield message._replace(data=decompress(message.data))
                except ValueError as error:
                    raise BagError(f"{path}: {error}") from None


def _in_order(
    sources: Iterable[tuple[int, Iterator[TimesBlock]]],
) -> Iterator[tuple[str, array[int]]]:
    """The blocks of sources that each begin at a time, merged.

    What is not before the times that may follow waits: little, unless everything overlaps.
    """
    heap = [(start_ns, number, source) for number, (start_ns, source) in enumerate(sources)]
    heapq.heapify(heap)
    waiting: dict[str, array[int]] = {}
    size = limit = 0
    while heap:
        _, number, source = heap[0]
        if (block := next(source, None)) is None:
            heapq.heappop(heap)
            continue
        until_ns, found = block
        heapq.heapreplace(heap, (until_ns, number, source))
        for topic, times in found.items():
            waiting.setdefault(topic, array("q")).extend(times)
            size += len(times)
        if size > limit:  # it grows with what stays, so that this is not sorted too often
            yield from _taken(waiting, heap[0][0])
            size = sum(map(len, waiting.values()))
            limit = max(_USUAL_TIMES, 2 * size)
    yield from _taken(waiting, None)


def _taken(
    waiting: dict[str, array[int]], until_ns: int | None
) -> Iterator[tuple[str, array[int]]]:
    """The times before this one (None: all), sorted; the others stay."""
    for topic, times in waiting.items():
        ordered = times if _is_sorted(times) else array("q", sorted(times))
        number = len(ordered) if until_ns is None else bisect.bisect_left(ordered, until_ns)
        waiting[topic] = ordered[number:]
        yield topic, ordered[:number]


def _is_sorted(times: array[int]) -> bool:
    return all(map(operator.le, times, itertools.islice(times, 1, None)))


def open_storage(path: str) -> McapFile | SqliteFile:
    """A storage file, decompressed if it has to be. BagError, OSError."""
    check_storage(path)
    name = os.path.basename(path)
    is_compressed = name.endswith(_SUFFIX)
    with contextlib.ExitStack() as stack:
        if is_compressed:
            stream = stack.enter_context(compression.decompressed(path))
        else:
            stream = stack.enter_context(open(path, "rb"))
        if name.removesuffix(_SUFFIX).endswith(".db3"):
            from launcher.bag.sqlite_file import SqliteFile

            return SqliteFile(stream.name, path)
        from launcher.bag.mcap.file import McapFile

        file = McapFile(stream, path)
        stack.pop_all()
    return file


def check_storage(path: str) -> None:
    """BagError for what cannot be a storage file, whatever its name says; OSError."""
    if not stat.S_ISREG(os.stat(path).st_mode):
        raise BagError(f"{path} is not a file")
    with open(path, "rb") as file:
        if text_file.is_pointer(file.read(len(text_file.POINTER))):
            raise BagError(text_file.pointer_sentence(path), hint=text_file.POINTER_HINT)


def _storage_file(path: str) -> str:
    if not os.path.exists(path):
        raise BagError(f"there is no bag at {path}")
    if os.path.basename(path) == metadata.FILE:
        raise BagError(
            f"{path} is only the metadata of a bag",
            hint=f"name its folder: {os.path.dirname(path) or '.'}",
        )
    if not _is_storage(path):
        raise BagError(
            f"{path} is not a bag", hint="a bag is a folder, or a file that ends in .mcap or .db3"
        )
    return path


def storage_files(folder: str) -> list[str]:
    """The names of the storage files in a folder, in the order of their numbers."""
    names = {name for name in os.listdir(folder) if _is_storage(name)}
    # Where the compression of a file was interrupted, the uncompressed one is still there.
    names = {name for name in names if name.removesuffix(_SUFFIX) not in names - {name}}
    return sorted(names, key=_natural)


def _is_storage(name: str) -> bool:
    return name.removesuffix(_SUFFIX).endswith(_ENDINGS)


def _natural(name: str) -> list[tuple[int, str]]:
    """Sorts `x_10.mcap` behind `x_9.mcap`."""
    return [(int(part), "") if part.isdigit() else (0, part) for part in re.split(r"(\d+)", name)]


def _overlaps(extent: Extent, span: Span) -> bool:
    begins = span.end_ns is None or extent.start_ns < span.end_ns
    return begins and (span.start_ns is None or extent.end_ns >= span.start_ns)
