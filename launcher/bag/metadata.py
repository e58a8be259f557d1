"""`metadata.yaml` of a bag: version 9 is written, 1 to 9 are read."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml

from launcher.bag.bag_model import CDR, LAST_NS, BagError, Extent, Qos, Topic, one_line
from launcher.base import text_file, yaml_bounds
from launcher.base.errors import UsageError
from launcher.base.text import typed_error
from launcher.base.yaml_dumper import Dumper

FILE = "metadata.yaml"
VERSION = 9
_ROOT = "rosbag2_bagfile_information"

# The numbers that versions before 9 have in place of words, as in rmw/types.h.
_WORDS = {
    "history": ("system_default", "keep_last", "keep_all", "unknown"),
    "reliability": ("system_default", "reliable", "best_effort", "unknown", "best_available"),
    "durability": ("system_default", "transient_local", "volatile", "unknown", "best_available"),
    "liveliness": (
        "system_default",
        "automatic",
        "manual_by_node",
        "manual_by_topic",
        "unknown",
        "best_available",
    ),
}
TIMES = ("deadline", "lifespan", "liveliness_lease_duration")


@dataclass(frozen=True, slots=True, kw_only=True)
class File:
    """A storage file; its path is relative to the folder of the bag."""

    path: str
    extent: Extent


@dataclass(frozen=True, slots=True, kw_only=True)
class Metadata:
    """What `metadata.yaml` says. `compression_mode` is empty, `file` or `message`."""

    storage: str
    topics: Sequence[Topic]
    files: Sequence[File]
    extent: Extent
    compression_format: str = ""
    compression_mode: str = ""
    ros_distro: str = ""
    custom_data: Mapping[str, str] = field(default_factory=dict)
    version: int = VERSION


def document_in(path: str) -> Any:
    """What a YAML file of a user has; UsageError."""
    try:
        text = text_file.read(path)
        document = yaml_bounds.load(text)
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UsageError(yaml_bounds.sentence(error, path)) from None
    if text_file.is_pointer(text):
        raise UsageError(text_file.pointer_sentence(path), hint=text_file.POINTER_HINT)
    return document


def qos_from(value: object) -> tuple[Qos, ...]:
    """The profiles of an entry `offered_qos_profiles`: a list, or a YAML text of one.

    ValueError if it is something else.
    """
    if isinstance(value, str):
        try:
            value = yaml_bounds.load(value)
        except yaml.YAMLError as error:
            raise ValueError(one_line(error)) from None
    if value is None or value == "":
        return ()
    if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
        raise ValueError("they are no list of mappings")
    return tuple(_with_words(profile) for profile in value)


def known_qos(topic: str, value: object, notes: list[str]) -> tuple[Qos, ...]:
    """The profiles as a storage file has them; none, and a note, if they cannot be read."""
    try:
        return qos_from(value)
    except ValueError as error:
        notes.append(f"{topic}: its QoS profiles cannot be read: {error}")
        return ()


def _with_words(profile: Mapping[Any, Any]) -> dict[str, Any]:
    known: dict[str, Any] = {}
    for name, value in profile.items():
        words = _WORDS.get(name)
        if name in TIMES:
            known[name] = _duration(name, value)
        elif not isinstance(name, str) or not isinstance(value, str | int | float | None):
            raise ValueError(f"the policy {str(name)[:40]!r} has no simple value")
        elif words is not None and isinstance(value, int):
            known[name] = words[value] if 0 <= value < len(words) else "unknown"
        elif name == "depth" and (type(value) is not int or not 0 <= value <= LAST_NS):
            raise ValueError("a depth is no number")
        else:
            known[name] = value
    return known


def _duration(name: str, value: object) -> dict[str, int]:
    if not isinstance(value, dict) or not all(
        type(value.get(unit, 0)) is int and 0 <= value.get(unit, 0) <= LAST_NS
        for unit in ("sec", "nsec")
    ):
        raise ValueError(f"{name} is no time of sec and nsec")
    return {unit: value.get(unit, 0) for unit in ("sec", "nsec")}


def qos_text(profiles: Sequence[Qos]) -> str:
    """The YAML text of profiles, as channels of MCAP files have it."""
    return str(yaml.safe_dump([dict(one) for one in profiles], sort_keys=False)).strip()


def information(metadata: Metadata) -> dict[str, Any]:
    """The part of `metadata.yaml` below its root."""
    return {
        "version": VERSION,
        "storage_identifier": metadata.storage,
        "duration": {"nanoseconds": metadata.extent.duration_ns},
        "starting_time": {"nanoseconds_since_epoch": metadata.extent.start_ns},
        "message_count": metadata.extent.total,
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.type,
                    "serialization_format": topic.serialization,
                    "offered_qos_profiles": [dict(profile) for profile in topic.qos],
                    "type_description_hash": topic.type_hash,
                },
                "message_count": metadata.extent.counts.get(topic.name, 0),
            }
            for topic in metadata.topics
        ],
        "compression_format": metadata.compression_format,
        "compression_mode": metadata.compression_mode,
        "relative_file_paths": [file.path for file in metadata.files],
        "files": [
            {
                "path": file.path,
                "starting_time": {"nanoseconds_since_epoch": file.extent.start_ns},
                "duration": {"nanoseconds": file.extent.duration_ns},
                "message_count": file.extent.total,
            }
            for file in metadata.files
        ],
        "custom_data": dict(metadata.custom_data) or None,
        "ros_distro": metadata.ros_distro,
    }


def to_yaml(metadata: Metadata, *, root: bool = True) -> str:
    document = information(metadata)
    document = {_ROOT: document} if root else document
    return str(yaml.dump(document, Dumper=Dumper, sort_keys=False, allow_unicode=True, width=1000))


def write(folder: str, metadata: Metadata) -> None:
    """Replace `metadata.yaml`; OSError."""
    path = os.path.join(folder, FILE)
    with removed_after_error(f"{path}.tmp"):
        with open(f"{path}.tmp", "w", encoding="utf-8") as file:
            file.write(to_yaml(metadata))
            file.flush()
            os.fsync(file.fileno())
        os.replace(f"{path}.tmp", path)


@contextlib.contextmanager
def removed_after_error(path: str) -> Iterator[None]:
    """Remove a file that could not be written as a whole."""
    try:
        yield
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(path)
        raise


def read(folder: str) -> Metadata | None:
    """What a folder's `metadata.yaml` says; None without one. BagError if it is not valid."""
    path = os.path.join(folder, FILE)
    hint = _REPAIR.format(folder)
    try:
        text = text_file.read(path)
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise BagError(f"cannot read {path}: {one_line(error)}", hint=hint) from None
    if text_file.is_pointer(text):
        raise BagError(text_file.pointer_sentence(path), hint=text_file.POINTER_HINT)
    try:
        document = yaml_bounds.load(text)
    except yaml.YAMLError as error:
        raise BagError(f"cannot read {yaml_bounds.sentence(error, path)}", hint=hint) from None
    try:
        return _from(document[_ROOT])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        reason = typed_error(error)[:300]
        raise BagError(f"{path} is not the metadata of a bag ({reason})", hint=hint) from None


_REPAIR = "to write it anew: bag check --repair {}"


def _text(value: object, name: str) -> str:
    if not isinstance(value, str | int | float):
        raise ValueError(f"{name} is no text")
    text = str(value)
    text.encode()  # ValueError for what YAML's escapes can make, and UTF-8 lacks
    return text


def _optional(value: object, name: str) -> str:
    return "" if value is None else _text(value, name)


def _number(value: object, name: str) -> int:
    """At most what 63 bits have, as times and counts of ROS."""
    if type(value) is not int or not 0 <= value <= LAST_NS:
        raise ValueError(f"{name} is not a number from 0 to 2^63 - 1")
    return value


def _from(info: Mapping[str, Any]) -> Metadata:
    counted = list(_counted_topics(info))
    whole = Extent({}, *_times(info))
    for topic, count in counted:  # there may be several entries of a name, with other QoS each
        whole.counts[topic.name] = whole.counts.get(topic.name, 0) + count
    mode = _optional(info.get("compression_mode"), "compression_mode")
    custom = info.get("custom_data") or {}
    return Metadata(
        version=_number(info["version"], "version"),
        storage=_text(info["storage_identifier"], "storage_identifier"),
        topics=[topic for topic, _ in counted],
        files=list(_files(info, whole)),
        extent=whole,
        compression_format=_optional(info.get("compression_format"), "compression_format"),
        compression_mode=mode.lower().replace("none", ""),
        ros_distro=_optional(info.get("ros_distro"), "ros_distro"),
        custom_data={
            _text(name, "a name of custom_data"): _optional(value, f"custom_data: {name}")
            for name, value in custom.items()
        },
    )


def _counted_topics(info: Mapping[str, Any]) -> Iterator[tuple[Topic, int]]:
    for entry in info["topics_with_message_count"] or ():
        data = entry["topic_metadata"]
        name = _text(data["name"], "the name of a topic")
        topic = Topic(
            name=name,
            type=_text(data["type"], f"the type of {name}"),
            serialization=_text(data.get("serialization_format", CDR), "serialization_format"),
            qos=qos_from(data.get("offered_qos_profiles")),
            type_hash=_optional(data.get("type_description_hash"), "type_description_hash"),
        )
        yield topic, _number(entry["message_count"], f"the count of {name}")


def _times(entry: Mapping[str, Any]) -> tuple[int, int]:
    start = _number(entry["starting_time"]["nanoseconds_since_epoch"], "starting_time")
    duration = _number(entry["duration"]["nanoseconds"], "duration")
    return start, _number(start + duration, "the end")


def _files(info: Mapping[str, Any], whole: Extent) -> Iterator[File]:
    """The files; versions before 5 name only their paths, and some of them with the folder."""
    details = {
        _text(entry["path"], "the path of a file"): entry for entry in info.get("files") or ()
    }
    for value in info["relative_file_paths"]:
        path = _text(value, "the path of a file")
        if "\0" in path:
            raise ValueError("the path of a file has a zero byte")
        if entry := details.get(path):
            number = _number(entry["message_count"], f"the count of {path}")
            yield File(path=path, extent=Extent({"": number}, *_times(entry)))
        else:
            yield File(path=path, extent=Extent({}, whole.start_ns, whole.end_ns))
