"""Find fields in conditions and expressions that a message type does not have.

A shape is a message class, `Several` of a shape, or a Python type; None is unknown and never wrong.
"""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rosidl_parser import definition

from launcher.base.document.fields import near
from launcher.base.errors import LauncherError
from launcher.smoke.expect.message_conditions import STEP, Conditions, Expression

_BASIC = {"boolean": bool, "float": float, "double": float, "long double": float, "octet": None}


@dataclass(frozen=True, slots=True)
class Several:
    element: object


def fields_of(shape: Any) -> Mapping[str, Any] | None:
    """Field -> its kind; None if the shape is not a message class."""
    if not hasattr(shape, "get_fields_and_field_types"):
        return None
    return dict(zip(shape.get_fields_and_field_types(), shape.SLOT_TYPES, strict=True))


def shape_of(kind: object) -> Any:
    if isinstance(kind, definition.AbstractNestedType):
        return Several(shape_of(kind.value_type))
    if isinstance(kind, definition.NamespacedType):
        *folders, name = kind.namespaced_name()
        return getattr(importlib.import_module(".".join(folders)), name, None)
    if isinstance(kind, definition.AbstractGenericString):
        return str
    return _BASIC.get(getattr(kind, "typename", ""), int)


def title(shape: Any) -> str:
    """The name of a shape for errors: `std_msgs/msg/String`."""
    if isinstance(shape, Several):
        return "a list"
    if fields_of(shape) is None:
        return {str: "a string", bool: "a boolean"}.get(shape, "a number")
    package, folder = shape.__module__.split(".")[:2]
    name, _, part = shape.__name__.partition("_")
    full = f"{package}/{folder}/{name}"
    return f"the {part.lower()} of {full}" if part else full


def _has_json(message: object) -> bool:
    """Whether its string `data` may be JSON."""
    kind = (fields_of(message) or {}).get("data")
    return isinstance(kind, definition.AbstractGenericString)


def _field(shape: object, name: str) -> Any:
    """The shape of a field; LauncherError if there is none."""
    fields = fields_of(shape) or {}
    if name not in fields:
        raise LauncherError(f"{title(shape)} has no field '{name}'", hint=near(name, fields))
    return shape_of(fields[name])


# ---- paths of fields


def faults_of_fields(
    conditions: Conditions, message: object
) -> Iterator[tuple[str, LauncherError]]:
    """(path, fault) of the conditions that no such message can satisfy."""
    for path, _ in conditions.fields:
        try:
            _follow_path(path, message)
        except LauncherError as fault:
            yield path, fault


def _follow_path(path: str, message: object) -> None:
    shape = message
    fields = fields_of(message) or {}
    for name, index in STEP.findall(path):
        if shape is message and name and _has_json(message) and name not in fields:
            return  # looked up in the JSON
        if fields_of(shape) is not None and name:
            shape = _field(shape, name)
        elif isinstance(shape, Several) and index:
            shape = shape.element
        elif shape is None:
            return
        else:
            asked = f"field '{name}'" if name else f"index [{index}]"
            raise LauncherError(f"'{path}': {title(shape)} has no {asked}")


# ---- expressions


def fault_of_expression(expression: Expression, message: object) -> LauncherError | None:
    """The first unknown field of the message in an expression."""
    tree = ast.parse(expression.text.strip(), mode="eval").body
    names = {name.id for name in ast.walk(tree) if isinstance(name, ast.Name)}
    if "json" in names and not _has_json(message):
        hint = f"use m: {', '.join(fields_of(message) or ())}"
        return LauncherError(f"{title(message)} has no string 'data' for JSON", hint=hint)
    if any(isinstance(part, ast.NamedExpr) for part in ast.walk(tree)):
        return None  # from where on the name has the new meaning is hard to find out
    try:
        _shape(tree, {"m": message})
    except LauncherError as fault:
        return fault
    return None


def _shape(node: ast.AST, names: Mapping[str, Any]) -> Any:
    """The shape of a part of an expression; LauncherError for an unknown field."""
    match node:
        case ast.Name(id=name):
            return names.get(name)
        case ast.Attribute(value=value, attr=attr):
            return _attribute(_shape(value, names), attr)
        case ast.Subscript(value=value, slice=index):
            _shape(index, names)
            return _entry(_shape(value, names), index)
        case ast.ListComp() | ast.SetComp() | ast.GeneratorExp() | ast.DictComp():
            return _comprehension(node, dict(names))
        case ast.Lambda(args=args, body=body):
            own = {arg.arg: None for arg in ast.walk(args) if isinstance(arg, ast.arg)}
            _shape(body, {**names, **own})
            return None
    for child in ast.iter_child_nodes(node):
        _shape(child, names)
    return None


def _attribute(shape: object, name: str) -> Any:
    if fields_of(shape) is not None:
        return _field(shape, name)
    example: object = [] if isinstance(shape, Several) else shape
    if shape is not None and not hasattr(example, name):
        raise LauncherError(f"{title(shape)} has no '{name}'")
    return None


def _entry(shape: object, index: ast.AST) -> Any:
    if isinstance(shape, Several):
        return shape if isinstance(index, ast.Slice) else shape.element
    if fields_of(shape) is None or not isinstance(index, ast.Constant):
        return None
    return _field(shape, str(index.value))


def _comprehension(node: Any, names: dict[str, Any]) -> None:
    for part in node.generators:
        many = _shape(part.iter, names)
        stored = (n.id for n in ast.walk(part.target) if isinstance(n, ast.Name))
        names |= dict.fromkeys(stored)
        if isinstance(part.target, ast.Name) and isinstance(many, Several):
            names[part.target.id] = many.element
        for condition in part.ifs:
            _shape(condition, names)
    results = [node.key, node.value] if isinstance(node, ast.DictComp) else [node.elt]
    for result in results:
        _shape(result, names)
