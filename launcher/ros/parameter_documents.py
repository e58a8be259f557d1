"""Parameter files, as `ros2 param dump` writes and `ros2 param load` reads them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import yaml

from launcher.base import text_file, yaml_bounds
from launcher.base.model.parameter_sections import PARAMETERS, parameters_for, sections
from launcher.base.model.parameter_text import rcl_loader
from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.ros.messages.from_yaml import TEXTS, value_of
from launcher.ros.parameter_values import Written


def dump_document(node: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """The parameter file of a node; dots in names become levels, if there is no such parameter."""
    tree: dict[str, Any] = {}
    for name in sorted(values):
        branch, rest = tree, name
        while "." in rest and isinstance(branch.get(rest.partition(".")[0], {}), dict):
            group, _, rest = rest.partition(".")
            branch = branch.setdefault(group, {})
        branch[rest] = values[name]
    return {node: {"ros__parameters": tree}}


def file_values(path: str, node: str, *, use_wildcard: bool) -> dict[str, Written]:
    """Name -> value for a node from a parameter file; VerbError if it has none for it."""
    text = _text(path)
    values, words = (
        _of_node(_tree(text, loader, path), path, node, use_wildcard=use_wildcard)
        for loader in (rcl_loader(), TEXTS)
    )
    return {name: Written(value, words.get(name)) for name, value in values.items()}


def _of_node(document: object, path: str, node: str, *, use_wildcard: bool) -> dict[str, Any]:
    try:
        known = list(sections(document))
        usable = [one for one in known if one.is_exact or use_wildcard]
        own = [one for one in usable if one.is_for(node)]
        for one in own:
            if one.parameters not in (None, "") and not isinstance(one.parameters, Mapping):
                where = f"'{PARAMETERS}' of '{one.selector}'"
                raise VerbError(f"{path}: expected names of parameters below {where}")
        if own:
            return {name: value for name, _, value in parameters_for(node, own)}
    except RecursionError:
        raise VerbError(f"{path}: a section contains itself") from None
    if not known and document:
        raise VerbError(f"{path}: expected '{PARAMETERS}' below the name of the node")
    names = [one.selector for one in known]
    near = did_you_mean(node, names)
    hint = f"it is for: {', '.join(names) or 'nothing'}" + (f"; {near}" if near else "")
    if not use_wildcard and any(one.is_for(node) for one in known):
        hint += "; without --no-use-wildcard, what is below a wildcard is taken"
    raise VerbError(f"Param file does not contain parameters for {node}", hint=hint)


def _text(path: str) -> str:
    try:
        text = text_file.read(path)
    except (OSError, ValueError) as error:
        raise VerbError(f"{path}: {getattr(error, 'strerror', None) or error}") from None
    if text_file.is_pointer(text):
        raise VerbError(text_file.pointer_sentence(path), hint=text_file.POINTER_HINT)
    return text


def _tree(text: str, loader: object, path: str) -> dict[str, Any]:
    try:
        document = value_of(text, loader)
    except yaml.YAMLError as error:
        raise VerbError(yaml_bounds.sentence(error, path)) from None
    if not isinstance(document, dict):
        raise VerbError(f"{path}: expected names of nodes at the top")
    return document
