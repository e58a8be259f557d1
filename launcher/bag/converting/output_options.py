"""The YAML files of `ros2 bag convert`: lists of bags to read, and to write."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from launcher.bag import compression
from launcher.bag.bag_model import Span
from launcher.bag.converting.convert import Output
from launcher.bag.converting.time_texts import Moment
from launcher.bag.metadata import document_in
from launcher.bag.topic_selection import Selection
from launcher.bag.writer import Storage
from launcher.base.errors import UsageError
from launcher.base.model.ros_names import full_name
from launcher.base.text import did_you_mean

_INPUTS, _OUTPUTS = "input_bags", "output_bags"


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise ValueError("is not true or false")
    return value


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise ValueError("is not a text")
    return value


def _number(value: object) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise ValueError("is not a whole number of at least 0")
    return value


def _time(value: object) -> int | None:
    """None if it is not after 0: then there is no limit."""
    if not isinstance(value, int) or isinstance(value, bool):
        raise ValueError("is not a whole number")
    return value if value > 0 else None


def _texts(value: object) -> list[str]:
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise ValueError("is not a list of texts")
    return value


def _expression(value: object) -> re.Pattern[str] | None:
    text = _text(value)
    try:
        return re.compile(text) if text else None
    except re.error as error:
        raise ValueError(f"is not a regular expression: {error}") from None


def _mapping(value: object) -> dict[str, str]:
    if not isinstance(value, dict):
        raise ValueError("is not a mapping")
    return {str(key): str(one) for key, one in value.items()}


def _word(*known: str) -> Callable[[object], str]:
    def read(value: object) -> str:
        word = _text(value).lower()
        if word not in known:
            raise ValueError(f"is not one of {', '.join(one for one in known if one)}")
        return word

    return read


def _storage_id(value: object) -> str:
    if value not in ("", "mcap"):
        raise ValueError("cannot be written, only mcap can")
    return str(value)


_KEYS: Mapping[str, Callable[[object], Any]] = {
    "uri": _text,
    "storage_id": _storage_id,
    "all": _flag,
    "all_topics": _flag,
    "all_services": _flag,
    "all_actions": _flag,
    "topics": _texts,
    "services": _texts,
    "actions": _texts,
    "topic_types": _texts,
    "regex": _expression,
    "exclude": _expression,
    "exclude_regex": _expression,
    "exclude_topics": _texts,
    "exclude_services": _texts,
    "exclude_actions": _texts,
    "exclude_topic_types": _texts,
    "compression_mode": _word("", *compression.MODES),
    "compression_format": _word("", *compression.FORMATS),
    "storage_preset_profile": _word("", *compression.PRESETS),
    "max_bagfile_size": _number,
    "max_bagfile_duration": _number,
    "max_bag_files": _number,
    "start_time_ns": _time,
    "end_time_ns": _time,
    "custom_data": _mapping,
}
# Of a bag to read; the others are of writing, and in the same list in rosbag2.
_OF_READING: Mapping[str, Callable[[object], Any]] = {
    "uri": _text,
    "start_time_ns": _time,
    "end_time_ns": _time,
    **dict.fromkeys(
        (
            "storage_id",
            "max_bagfile_size",
            "max_bagfile_duration",
            "max_bag_files",
            "storage_preset_profile",
            "custom_data",
        ),
        lambda value: None,
    ),
}
# Of recording, without effect on what is written.
_IGNORED = frozenset(
    {
        "compression_queue_size",
        "compression_threads",
        "compression_threads_priority",
        "disable_keyboard_controls",
        "ignore_leaf_topics",
        "include_hidden_topics",
        "include_unpublished_topics",
        "input_serialization_format",
        "is_discovery_disabled",
        "max_cache_duration",
        "max_cache_size",
        "node_prefix",
        "output_serialization_format",
        "repeat_all_transient_local_depth",
        "repeat_transient_local_messages",
        "rmw_serialization_format",
        "snapshot_mode",
        "start_paused",
        "static_topics_uri",
        "statistics_max_publishing_rate",
        "storage_config_uri",
        "topic_polling_interval",
        "topic_qos_profile_overrides",
        "use_sim_time",
    }
)


@dataclass(frozen=True, slots=True)
class _BagOptions:
    """A bag in a list of the file, for messages."""

    path: str
    root: str
    number: int

    def wrong(self, text: str, hint: str | None = None) -> UsageError:
        return UsageError(f"{self.path}: {self.root}, entry {self.number}: {text}", hint=hint)


@dataclass(frozen=True, slots=True)
class InputPart:
    """A bag to read, or a part of it."""

    path: str
    span: Span


def read_inputs(path: str) -> list[InputPart]:
    """UsageError for a mistake in the file. The files of a bag show their storage."""
    entries = _entries(path, _INPUTS, "read", _OF_READING)
    return [InputPart(values["uri"], _span(values)) for _, values in entries]


def read(path: str) -> list[Output]:
    """UsageError for a mistake in the file."""
    found: list[Output] = []
    for place, values in _entries(path, _OUTPUTS, "write", _KEYS):
        if any(one.path == values["uri"] for one in found):
            raise place.wrong(f"'{values['uri']}' is another entry's uri, too")
        found.append(_output(values))
    return found


def _entries(
    path: str, root: str, verb: str, keys: Mapping[str, Callable[[object], Any]]
) -> Iterator[tuple[_BagOptions, dict[str, Any]]]:
    document = document_in(path)
    entries = document.get(root) if isinstance(document, dict) else None
    if not isinstance(entries, list) or not entries:
        raise UsageError(f"{path} has no list '{root}'", hint=f"it begins with: {root}:")
    lists = (_INPUTS, _OUTPUTS)
    for key in document if isinstance(document, dict) else ():
        if key not in lists:
            hint = did_you_mean(str(key), lists) or f"known: {', '.join(lists)}"
            raise UsageError(f"{path}: unknown key '{key}'", hint=hint)
    for number, entry in enumerate(entries, 1):
        place = _BagOptions(path, root, number)
        if not isinstance(entry, dict):
            raise place.wrong("it is not a mapping", "as in - uri: bag")
        values = {str(key): _value(place, str(key), value, keys) for key, value in entry.items()}
        if not values.get("uri"):
            raise place.wrong(f"'uri' is missing, the bag to {verb}")
        start_ns, end_ns = _span(values)
        if start_ns is not None and end_ns is not None and start_ns >= end_ns:
            raise place.wrong("end_time_ns is before start_time_ns")
        yield place, values


def _span(values: Mapping[str, Any]) -> Span:
    """In these files the last time belongs to it."""
    end_ns = values.get("end_time_ns")
    return Span(values.get("start_time_ns"), None if end_ns is None else end_ns + 1)


def _output(values: Mapping[str, Any]) -> Output:
    start_ns, end_ns = _span(values)
    return Output(
        path=values["uri"],
        selection=_selection(values),
        start=None if start_ns is None else Moment(start_ns, from_start=False),
        end=None if end_ns is None else Moment(end_ns, from_start=False),
        storage=Storage(
            chunk_compression=compression.PRESETS[
                values.get("storage_preset_profile") or "zstd_fast"
            ],
            mode=values.get("compression_mode") or "none",
            format=values.get("compression_format") or compression.FORMATS[0],
            max_bytes=values.get("max_bagfile_size", 0),
            max_duration_ns=values.get("max_bagfile_duration", 0) * 10**9,
            max_files=values.get("max_bag_files", 0),
        ),
        custom_data=values.get("custom_data", {}),
    )


def _value(
    place: _BagOptions, key: str, value: object, keys: Mapping[str, Callable[[object], Any]]
) -> Any:
    if key in _IGNORED:
        return None
    if key not in keys:
        hint = did_you_mean(key, keys) or f"known: {', '.join(keys)}"
        raise place.wrong(f"unknown key '{key}'", hint)
    try:
        return keys[key](value)
    except ValueError as error:
        raise place.wrong(f"{key}: '{value}' {error}") from None


def _selection(values: Mapping[str, Any]) -> Selection:
    """Everything, unless something is selected."""

    def names(key: str) -> frozenset[str]:
        return frozenset(map(full_name, values.get(key, ())))

    kinds = ("topics", "services", "actions")
    keys = ("all", *kinds, *(f"all_{kind}" for kind in kinds), "topic_types", "regex")
    everything = values.get("all", False) or not any(values.get(key) for key in keys)
    return Selection(
        all_topics=everything or values.get("all_topics", False),
        all_services=everything or values.get("all_services", False),
        all_actions=everything or values.get("all_actions", False),
        topics=names("topics"),
        services=names("services"),
        actions=names("actions"),
        types=values.get("topic_types", ()),
        regex=values.get("regex"),
        exclude_regex=values.get("exclude_regex") or values.get("exclude"),
        exclude_topics=names("exclude_topics"),
        exclude_services=names("exclude_services"),
        exclude_actions=names("exclude_actions"),
        exclude_types=values.get("exclude_topic_types", ()),
        hidden=True,
    )
