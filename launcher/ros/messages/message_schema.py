"""Definitions of types with all that they need, as bags and Foxglove have them (`ros2msg`)."""

from __future__ import annotations

import functools
from typing import NamedTuple

from launcher.base import strict_json
from launcher.base.ros_errors import VerbError
from launcher.ros.messages.interfaces import (
    absent,
    code_of,
    definition_path,
    interface_packages,
    interfaces_of,
    nested_type,
)

_SEPARATOR = "=" * 80

# The messages that are sections of a file, and their number.
_SECTIONS = {
    "msg": {"": 0},
    "srv": {"_Request": 0, "_Response": 1},
    "action": {"_Goal": 0, "_Result": 1, "_Feedback": 2},
}
_UUID = "unique_identifier_msgs/UUID goal_id"
# The messages that ROS's generator adds; OWN is the name without the suffix.
_EVENT = (
    "service_msgs/ServiceEventInfo info",
    "OWN_Request[<=1] request",
    "OWN_Response[<=1] response",
)
_GENERATED: dict[str, dict[str, tuple[str, ...]]] = {
    "msg": {},
    "srv": {"_Event": _EVENT},
    "action": {
        "_SendGoal_Request": (_UUID, "OWN_Goal goal"),
        "_SendGoal_Response": ("bool accepted", "builtin_interfaces/Time stamp"),
        "_SendGoal_Event": tuple(line.replace("OWN", "OWN_SendGoal") for line in _EVENT),
        "_GetResult_Request": (_UUID,),
        "_GetResult_Response": ("int8 status", "OWN_Result result"),
        "_GetResult_Event": tuple(line.replace("OWN", "OWN_GetResult") for line in _EVENT),
        "_FeedbackMessage": (_UUID, "OWN_Feedback feedback"),
    },
}


class _Source(NamedTuple):
    """Which message of which installed interface a name means: `fleet/action/Fold`, `_Goal`."""

    interface: str
    suffix: str

    @property
    def kind(self) -> str:
        return self.interface.split("/")[1]


@functools.cache
def schema_text(full_type: str) -> str:
    """The definition, and those of the types that it needs in the order of their first use.

    `full_type` is a message (`std_msgs/msg/String`), or one of those that belong to a service or
    an action (`std_srvs/srv/Trigger_Request`, `fleet/action/Fold_FeedbackMessage`). VerbError if
    it, or what it needs, is not installed.
    """
    texts: dict[str, str] = {}

    def add(full: str, needed_by: str) -> None:
        if full not in texts:
            texts[full] = text = _definition(full, needed_by)
            for nested in _types_of_fields(full, text):
                add(nested, full)

    add(full_type, "")
    first, *others = texts
    return texts[first] + "".join(
        f"\n{_SEPARATOR}\nMSG: {_short(full)}\n{texts[full]}" for full in others
    )


@functools.cache
def rihs_hash(full_type: str) -> str:
    """The hash of a type (`RIHS01_...`), of services and actions, too; VerbError.

    DDS announces the same one with each publisher and subscription.
    """
    source = _source(full_type, services=True)
    path = definition_path(source.interface).with_suffix(".json")
    try:
        hashes = strict_json.loads(path.read_text(encoding="utf-8"))["type_hashes"]
        found = {entry["type_name"]: entry["hash_string"] for entry in hashes}
        return str(found[full_type])
    except (OSError, ValueError, LookupError, TypeError):
        raise VerbError(f"the hash of {full_type} is not installed: {path}") from None


def _source(full: str, *, needed_by: str = "", services: bool = False) -> _Source:
    """VerbError if nothing that is installed defines this name."""
    package, kind, name = full.split("/") if full.count("/") == 2 else ("", "", "")
    if kind in _SECTIONS and package in interface_packages():
        known = interfaces_of(package, [kind])
        suffixes = ["", "_SendGoal", "_GetResult"] if services else []
        for suffix in [*suffixes, *_SECTIONS[kind], *_GENERATED[kind]]:
            interface = f"{package}/{kind}/{name.removesuffix(suffix)}"
            if name.endswith(suffix) and interface in known:
                return _Source(interface, suffix)
    hint = absent(package) if package else None
    if needed_by:
        raise VerbError(f"{needed_by} needs {full}, which is not installed", hint=hint)
    raise VerbError(f"no definition of {full} is installed", hint=hint)


def _definition(full: str, needed_by: str) -> str:
    source = _source(full, needed_by=needed_by)
    if source.suffix in _GENERATED[source.kind]:
        lines = _GENERATED[source.kind][source.suffix]
        return "".join(f"{line.replace('OWN', _short(source.interface))}\n" for line in lines)
    return _sections(source.interface)[_SECTIONS[source.kind][source.suffix]]


def _sections(interface: str) -> list[str]:
    path = definition_path(interface)
    if path.suffix == ".idl":
        from launcher.ros.messages import idl_text  # its parser is slow to import

        return idl_text.sections(path)
    found: list[list[str]] = [[]]
    for line in path.read_text(encoding="utf-8").splitlines():
        if line == "---" and path.suffix != ".msg":
            found.append([])
        else:
            found[-1].append(f"{line}\n")
    return ["".join(lines) for lines in found]


def _types_of_fields(full: str, text: str) -> list[str]:
    """Full names; those of a service or an action are below the same one."""
    package, kind, _ = full.split("/")
    source = _source(full)
    own = (*_SECTIONS[kind], *_GENERATED[kind]) if source.suffix in _GENERATED[kind] else ()
    siblings = {f"{_short(source.interface)}{suffix}" for suffix in own}
    found: dict[str, None] = {}
    for line in text.splitlines():
        if nested := nested_type(code_of(line), package):
            is_sibling = _short(nested) in siblings
            found[nested.replace("/msg/", f"/{kind}/") if is_sibling else nested] = None
    return list(found)


def _short(full: str) -> str:
    """As fields name it: `std_msgs/String`."""
    package, _, name = full.split("/")
    return f"{package}/{name}"
