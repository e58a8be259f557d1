"""Remapping rules as launch files give them."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.language.class_tools import ensure_argument_type
from launcher.language.substitution import Substitution, normalize_to_list_of_substitutions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

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
    """Each rule normalised, when it is asked for."""
    return (normalize_remap_rule(rule) for rule in remap_rules)
