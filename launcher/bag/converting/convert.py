"""`bag convert`: bags into a new one, a file of MCAP, or a table."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any

from launcher.bag import metadata, quantity_texts
from launcher.bag.bag_model import BagError, Message, Span
from launcher.bag.converting.merged_bags import Complete, Merged
from launcher.bag.converting.text_tables import Csv, JsonLines, Notes, Readable
from launcher.bag.converting.time_texts import Moment
from launcher.bag.metadata import Metadata
from launcher.bag.reader import Bag
from launcher.bag.topic_selection import Selection
from launcher.bag.writer import BagWriter, McapOutput, Storage
from launcher.base.text import count

STDOUT = "-"
_KIND_OF = {".csv": "csv", ".jsonl": "jsonl", ".ndjson": "jsonl", ".json": "jsonl"}
_ALL = Selection(all_topics=True, all_services=True, all_actions=True, hidden=True)

Write = Callable[[Message], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Output:
    """What is written, and of what; `length_ns` counts from the start of the selected time."""

    path: str
    kind: str = "mcap"
    selection: Selection = _ALL
    start: Moment | None = None
    end: Moment | None = None
    length_ns: int | None = None
    remap: Mapping[str, str] = field(default_factory=dict)
    storage: Storage = field(default_factory=Storage)
    fields: Sequence[str] = ()
    custom_data: Mapping[str, str] = field(default_factory=dict)

    def span(self, start_ns: int) -> Span:
        """Of bags that begin at `start_ns`."""
        start = None if self.start is None else self.start.at(start_ns)
        end = None if self.end is None else self.end.at(start_ns)
        if self.length_ns is not None:
            end = (start_ns if start is None else start) + self.length_ns
        if start is not None and end is not None and start >= end:
            raise BagError(
                f"no time is selected: the end ({quantity_texts.date(end)}) is not after the start "
                f"({quantity_texts.date(start)})"
            )
        return Span(start, end)


def kind_of(path: str) -> str:
    """By the suffix."""
    return _KIND_OF.get(os.path.splitext(path)[1].lower(), "mcap")


def is_single_file(path: str) -> bool:
    """Whether MCAP goes to a file in place of the folder of a bag."""
    return path.endswith(".mcap")


def convert(
    bags: Sequence[Bag],
    output: Output,
    complete: Complete,
    notes: Notes,
    spans: Sequence[Span] | None = None,
) -> str:
    """Write the output; a sentence about it. BagError, and then nothing is left of it.

    `notes` gets a sentence for each topic that is left out of a table. `spans` are the parts of
    the bags that are read, None: all.
    """
    if output.path != STDOUT and os.path.lexists(output.path):
        raise BagError(f"{output.path} exists already", hint="name another one with -o")
    merged = Merged(bags, output.selection, output.remap, complete, spans)
    span = output.span(merged.start_ns)
    number, last_ns = 0, None
    with _opened(output, merged, span, notes) as write:
        for message in merged.messages(span):
            write(message)
            number, last_ns = number + 1, message.log_ns
    contents = f"{count(number, 'message')} of {count(len(merged.topics), 'topic')}"
    if last_ns is None:
        is_part = any(map(any, (span, *(spans or ()))))
        contents += " (there is none in the selected time)" if is_part else ""
    return f"wrote {output.path}: {contents}{_size(output.path)}"


def _size(path: str) -> str:
    if path == STDOUT:
        return ""
    files = [path]
    if os.path.isdir(path):
        files = [os.path.join(path, name) for name in os.listdir(path)]
    return f", {quantity_texts.size(sum(map(os.path.getsize, files)))}"


@contextmanager
def _opened(output: Output, merged: Merged, span: Span, notes: Notes) -> Iterator[Write]:
    if output.kind != "mcap":
        opened: Any = _table(output, Readable(merged, span, notes))
    elif is_single_file(output.path):
        opened = _file(output, merged)
    else:
        opened = _folder(output, merged)
    try:
        with opened as write:
            yield write
    except BrokenPipeError:
        raise
    except OSError as error:
        raise BagError(f"cannot write {output.path}: {error.strerror or error}") from None


@contextmanager
def _folder(output: Output, merged: Merged) -> Iterator[Write]:
    writer = BagWriter(
        output.path,
        output.storage,
        ros_distro=_ros_distro(merged),
        custom_data=_custom_data(output, merged),
    )
    try:
        for topic in merged.topics:
            writer.add_topic(topic)
        yield writer.write
        writer.close()
    except BaseException:
        writer.discard()
        raise


@contextmanager
def _file(output: Output, merged: Merged) -> Iterator[Write]:
    file = McapOutput(output.path, output.storage)
    try:
        for topic in merged.topics:
            file.add_topic(topic)
        yield file.write
        whole = Metadata(
            storage="mcap",
            topics=merged.topics,
            files=[file.entry],
            extent=file.extent,
            ros_distro=_ros_distro(merged),
            custom_data=_custom_data(output, merged),
        )
        file.finish(metadata.to_yaml(whole, root=False))
    except BaseException:
        file.abandon()
        os.unlink(output.path)
        raise


@contextmanager
def _table(output: Output, readable: Readable) -> Iterator[Write]:
    kind = Csv if output.kind == "csv" else JsonLines
    if output.path == STDOUT:
        yield kind(readable, sys.stdout, output.fields).write
        return
    with open(output.path, "x", encoding="utf-8", newline="") as stream:
        try:
            yield kind(readable, stream, output.fields).write
            stream.flush()
            os.fsync(stream.fileno())
        except BaseException:
            os.unlink(output.path)
            with suppress(OSError):  # of writing what is still in the buffer
                stream.close()
            raise


def _ros_distro(merged: Merged) -> str:
    known = (bag.metadata.ros_distro for bag in merged.bags if bag.metadata is not None)
    return next(filter(None, known), "")


def _custom_data(output: Output, merged: Merged) -> dict[str, str]:
    found: dict[str, str] = {}
    for bag in merged.bags:
        found |= dict(bag.metadata.custom_data) if bag.metadata is not None else {}
    return {**found, **output.custom_data}
