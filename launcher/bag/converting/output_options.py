"""The YAML file of `ros2 bag convert -o`: a list of bags to write, with options of recording."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from launcher.bag import compression
from launcher.bag.converting.convert import Output
from launcher.bag.converting.time_texts import Moment
from launcher.bag.metadata import document_in
from launcher.bag.topic_selection import Selection
from launcher.bag.writer import Storage
from launcher.base.errors import UsageError
from launcher.base.model.ros_names import full_name
from launcher.base.text import did_you_mean

_ROOT = "output_bags"


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
    "start_time_ns": _number,
    "end_time_ns": _number,
    "custom_data": _mapping,
}
# Of recording, without effect on what is written.
_IGNORED = frozenset(
    {
        "compression_queue_size",
        "compression_threads",
        "compression_threads_priority",
        "ignore_leaf_topics",
        "include_hidden_topics",
        "include_unpublished_topics",
        "is_discovery_disabled",
        "max_cache_size",
        "node_prefix",
        "rmw_serialization_format",
        "snapshot_mode",
        "storage_config_uri",
        "topic_polling_interval",
        "topic_qos_profile_overrides",
        "use_sim_time",
    }
)


@dataclass(frozen=True, slots=True)
class _BagOptions:
    """A bag in the file, for messages."""

    path: str
    number: int

    def wrong(self, text: str, hint: str | None = None) -> UsageError:
        return UsageError(f"{self.path}: {_ROOT}, entry {self.number}: {text}", hint=hint)


def read(path: str) -> list[Output]:
    """UsageError for a mistake in the file."""
    document = document_in(path)
    entries = document.get(_ROOT) if isinstance(document, dict) else None
    if not isinstance(entries, list) or not entries:
        raise UsageError(f"{path} has no list '{_ROOT}'", hint="it begins with: output_bags:")
    found = [_output(_BagOptions(path, number), entry) for number, entry in enumerate(entries, 1)]
    uris = [output.path for output in found]
    for number, uri in enumerate(uris, 1):
        if uri in uris[: number - 1]:
            raise _BagOptions(path, number).wrong(f"'{uri}' is another entry's uri, too")
    return found


def _output(place: _BagOptions, entry: object) -> Output:
    if not isinstance(entry, dict):
        raise place.wrong("it is not a mapping", "as in - uri: out")
    values = {str(key): _value(place, str(key), value) for key, value in entry.items()}
    if not values.get("uri"):
        raise place.wrong("'uri' is missing, the bag to write")
    start, end = values.get("start_time_ns", 0), values.get("end_time_ns", 0)
    return Output(
        path=values["uri"],
        selection=_selection(values),
        start=Moment(start, from_start=False) if start else None,
        end=Moment(end, from_start=False) if end else None,
        storage=Storage(
            chunk_compression=compression.PRESETS[
                values.get("storage_preset_profile") or "zstd_fast"
            ],
            mode=values.get("compression_mode") or "none",
            format=values.get("compression_format") or compression.FORMATS[0],
            max_bytes=values.get("max_bagfile_size", 0),
            max_duration_ns=values.get("max_bagfile_duration", 0) * 10**9,
        ),
        custom_data=values.get("custom_data", {}),
    )


def _value(place: _BagOptions, key: str, value: object) -> Any:
    if key in _IGNORED:
        return None
    if key not in _KEYS:
        hint = did_you_mean(key, _KEYS) or f"known: {', '.join(_KEYS)}"
        raise place.wrong(f"unknown key '{key}'", hint)
    try:
        return _KEYS[key](value)
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
