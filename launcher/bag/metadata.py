"""`metadata.yaml` of a bag: version 9 is written, 1 to 9 are read."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml

from launcher.bag.errors import BagError
from launcher.bag.model import CDR, Extent, Qos, Topic
from launcher.text import typed_error
from launcher.yaml_dumper import Dumper

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


def qos_from(value: Any) -> tuple[Qos, ...]:
    """The profiles of an entry `offered_qos_profiles`: a list, or a YAML text of one."""
    if isinstance(value, str):
        value = yaml.safe_load(value) if value.strip() else []
    return tuple(_with_words(profile) for profile in value or ())


def _with_words(profile: Mapping[str, Any]) -> dict[str, Any]:
    known: dict[str, Any] = {}
    for name, value in profile.items():
        words = _WORDS.get(name)
        if words is not None and isinstance(value, int):
            known[name] = words[value] if 0 <= value < len(words) else "unknown"
        else:
            known[name] = value
    return known


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
    return _dump({_ROOT: document} if root else document)


def _dump(document: Any) -> str:
    return str(yaml.dump(document, Dumper=Dumper, sort_keys=False, allow_unicode=True, width=1000))


def write(folder: str, metadata: Metadata) -> None:
    """Replace `metadata.yaml`; OSError."""
    path = os.path.join(folder, FILE)
    with open(f"{path}.tmp", "w", encoding="utf-8") as file:
        file.write(to_yaml(metadata))
        file.flush()
        os.fsync(file.fileno())
    os.replace(f"{path}.tmp", path)


def read(folder: str) -> Metadata | None:
    """What a folder's `metadata.yaml` says; None without one. BagError if it is not valid."""
    path = os.path.join(folder, FILE)
    try:
        with open(path, encoding="utf-8") as file:
            document = yaml.safe_load(file)
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        reason = " ".join(str(error).split())
        raise BagError(f"cannot read {path}: {reason}", hint=_REPAIR.format(folder)) from None
    try:
        return _from(document[_ROOT])
    except (KeyError, TypeError, ValueError, AttributeError, yaml.YAMLError) as error:
        reason = typed_error(error)
        raise BagError(
            f"{path} is not the metadata of a bag ({reason})", hint=_REPAIR.format(folder)
        ) from None


_REPAIR = "to write it anew: bag check --repair {}"


def _from(info: Mapping[str, Any]) -> Metadata:
    counted = list(_counted_topics(info))
    whole = Extent({}, *_times(info))
    for topic, count in counted:  # there may be several entries of a name, with other QoS each
        whole.counts[topic.name] = whole.counts.get(topic.name, 0) + count
    return Metadata(
        version=int(info["version"]),
        storage=str(info["storage_identifier"]),
        topics=[topic for topic, _ in counted],
        files=list(_files(info, whole)),
        extent=whole,
        compression_format=str(info.get("compression_format") or ""),
        compression_mode=str(info.get("compression_mode") or "").lower().replace("none", ""),
        ros_distro=str(info.get("ros_distro") or ""),
        custom_data={str(k): str(v) for k, v in (info.get("custom_data") or {}).items()},
    )


def _counted_topics(info: Mapping[str, Any]) -> Iterator[tuple[Topic, int]]:
    for entry in info["topics_with_message_count"] or ():
        data = entry["topic_metadata"]
        topic = Topic(
            name=str(data["name"]),
            type=str(data["type"]),
            serialization=str(data.get("serialization_format", CDR)),
            qos=qos_from(data.get("offered_qos_profiles")),
            type_hash=str(data.get("type_description_hash") or ""),
        )
        yield topic, int(entry["message_count"])


def _times(entry: Mapping[str, Any]) -> tuple[int, int]:
    start = int(entry["starting_time"]["nanoseconds_since_epoch"])
    return start, start + int(entry["duration"]["nanoseconds"])


def _files(info: Mapping[str, Any], whole: Extent) -> Iterator[File]:
    """The files; versions before 5 name only their paths, and some of them with the folder."""
    details = {entry["path"]: entry for entry in info.get("files") or ()}
    for path in info["relative_file_paths"]:
        if entry := details.get(path):
            yield File(path=path, extent=Extent({"": int(entry["message_count"])}, *_times(entry)))
        else:
            yield File(path=path, extent=Extent({}, whole.start_ns, whole.end_ns))
