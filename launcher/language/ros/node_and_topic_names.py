"""ROS names: validation, namespaces, remapping rules, and how often a node name was used."""

from __future__ import annotations

import re
from collections.abc import Iterable

from launcher.language.class_tools import ensure_argument_type
from launcher.language.naming import public
from launcher.language.substitution import (
    Substitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn

    from launcher.language.context import LaunchContext


_MAX_NODE_NAME = 255
_MAX_NAMESPACE = 245  # what rmw leaves for a namespace
_NAME_CHARACTERS = "alphanumerics or '_'"


@public("rclpy.exceptions")
class NameValidationException(Exception):
    """A ROS name breaks the rules; the message points at the character."""

    def __init__(self, name_type: str, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__(
            f"Invalid {name_type}: {error_msg}:\n  '{name}'\n   {' ' * invalid_index}^"
        )


@public("rclpy.exceptions")
class InvalidNodeNameException(NameValidationException):
    """A node name breaks the rules."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__("node name", name, error_msg, invalid_index)


@public("rclpy.exceptions")
class InvalidNamespaceException(NameValidationException):
    """A namespace breaks the rules."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__("namespace", name, error_msg, invalid_index)


def validate_node_name(name: str) -> bool:
    """True; InvalidNodeNameException for an empty, long or misspelt name."""

    def fail(message: str, index: int) -> NoReturn:
        raise InvalidNodeNameException(name, message, index)

    if not name:
        fail("node name must not be empty", 0)
    bad = re.search(r"[^A-Za-z0-9_]", name)
    if bad:
        fail(f"node name must not contain characters other than {_NAME_CHARACTERS}", bad.start())
    if name[0].isdigit():
        fail("node name must not start with a number", 0)
    if len(name) > _MAX_NODE_NAME:
        fail(f"node name length should not exceed '{_MAX_NODE_NAME}'", _MAX_NODE_NAME - 1)
    return True


def validate_namespace(namespace: str) -> bool:
    """True; InvalidNamespaceException unless it is an absolute, well-formed namespace."""

    def fail(message: str, index: int) -> NoReturn:
        raise InvalidNamespaceException(namespace, message, index)

    if not namespace:
        fail("namespace must not be empty", 0)
    if not namespace.startswith("/"):
        fail("namespace must be absolute, it must lead with a '/'", 0)
    if namespace != "/" and namespace.endswith("/"):
        fail("namespace must not end with a '/', unless only a '/'", len(namespace) - 1)
    bad = re.search(r"[^A-Za-z0-9_/]", namespace)
    if bad:
        message = f"namespace must not contain characters other than {_NAME_CHARACTERS}, or '/'"
        fail(message.replace("alphanumerics or '_',", "alphanumerics, '_',"), bad.start())
    repeated = namespace.find("//")
    if repeated >= 0:
        fail("namespace must not contain repeated '/'", repeated + 1)
    digit = re.search(r"/[0-9]", namespace)
    if digit:
        fail("namespace must not have a token that starts with a number", digit.start() + 1)
    if len(namespace) > _MAX_NAMESPACE:
        fail("namespace is too long", _MAX_NAMESPACE - 1)
    return True


def is_root_namespace(ns: str) -> bool:
    """Whether it is `/`."""
    return ns == "/"


def is_namespace_absolute(ns: str) -> bool:
    """Whether it begins with a slash."""
    return ns.startswith("/")


def make_namespace_absolute(ns: str | None) -> str | None:
    """The namespace with a slash in front; None stays None."""
    if ns is None or is_namespace_absolute(ns):
        return ns
    return "/" + ns


def prefix_namespace(base_ns: str | None, ns: str | None) -> str | None:
    """`ns` below `base_ns`; an absolute `ns` is returned as it is."""
    if base_ns is None and ns is None:
        return None
    if ns is None:
        combined = str(base_ns)
    elif not base_ns or is_namespace_absolute(ns):
        combined = ns
    else:
        combined = f"{'' if is_root_namespace(base_ns) else base_ns}/{ns}"
    return combined if is_root_namespace(combined) else combined.rstrip("/")


def resolve_namespace(context: LaunchContext, namespace: str | None) -> str | None:
    """The absolute namespace below those of PushROSNamespace; None if neither is given."""
    pushed = context.launch_configurations.get("ros_namespace", None)
    return make_namespace_absolute(prefix_namespace(pushed, namespace))


_KEY = "unique_ros_node_names"


def add_node_name(context: LaunchContext, node_name: str) -> None:
    """Count one more use."""
    counts = context.get_locals_as_dict().get(_KEY)
    if counts is None:
        counts = {}
        context.extend_globals({_KEY: counts})
    counts[node_name] = counts.get(node_name, 0) + 1


def get_node_name_count(context: LaunchContext, node_name: str) -> int:
    """The number of uses."""
    count: int = context.get_locals_as_dict().get(_KEY, {}).get(node_name, 0)
    return count


RemapRule = tuple[tuple[Substitution, ...], tuple[Substitution, ...]]


def normalize_remap_rule(remap_rule: Any) -> RemapRule:
    """A (from, to) tuple with both sides as tuples of substitutions; TypeError otherwise."""
    ensure_argument_type(remap_rule, (tuple,), "remap_rule")
    if len(remap_rule) != 2:
        raise TypeError(f"remap_rule must be a tuple of length 2, got length {len(remap_rule)}")
    source, destination = remap_rule
    return (
        tuple(normalize_to_list_of_substitutions(source)),
        tuple(normalize_to_list_of_substitutions(destination)),
    )


def normalize_remap_rules(remap_rules: Iterable[Any]) -> Iterable[RemapRule]:
    """A lazy iterable of the normalised rules."""
    return (normalize_remap_rule(rule) for rule in remap_rules)


def evaluate_remap_rules(
    context: LaunchContext, rules: Iterable[RemapRule]
) -> list[tuple[str, str]]:
    """(from, to) pairs: those of SetRemap, then those of `rules`."""
    pairs = list(context.launch_configurations.get("ros_remaps", None) or ())
    pairs += [
        (perform_substitutions(context, src), perform_substitutions(context, dst))
        for src, dst in rules
    ]
    return pairs
