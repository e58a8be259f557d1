"""Shapes: which fields a message has, and whether a condition asks for one that it has not.

A shape is a class of messages, a list of shapes, or a plain Python type; None is unknown, and
whatever is done to what is unknown may be right.
"""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rosidl_parser import definition

from launcher.smoke.expect.conditions import STEP, Conditions, Expression
from launcher.smoke.expect.fields import near

Fault = tuple[str, str | None]  # a sentence and a hint
_BASIC = {"boolean": bool, "float": float, "double": float, "long double": float, "octet": None}


@dataclass(frozen=True, slots=True)
class Several:
    """An array or a sequence of something."""

    element: Any


def fields_of(shape: Any) -> Mapping[str, Any] | None:
    """Field -> its kind, of a class of messages; None of what is none."""
    if not hasattr(shape, "get_fields_and_field_types"):
        return None
    return dict(zip(shape.get_fields_and_field_types(), shape.SLOT_TYPES, strict=True))


def shape_of(kind: Any) -> Any:
    """The shape of a field of this kind."""
    if isinstance(kind, definition.AbstractNestedType):
        return Several(shape_of(kind.value_type))
    if isinstance(kind, definition.NamespacedType):
        *folders, name = kind.namespaced_name()
        return getattr(importlib.import_module(".".join(folders)), name, None)
    if isinstance(kind, definition.AbstractGenericString):
        return str
    return _BASIC.get(getattr(kind, "typename", ""), int)


def title(shape: Any) -> str:
    """What a shape is called in a sentence: `std_msgs/msg/String`."""
    if isinstance(shape, Several):
        return "a list"
    if fields_of(shape) is None:
        return {str: "a text", bool: "true or false"}.get(shape, "a number")
    package, folder = shape.__module__.split(".")[:2]
    name, _, part = shape.__name__.partition("_")
    full = f"{package}/{folder}/{name}"
    return f"the {part.lower()} of {full}" if part else full


def _has_json(message: Any) -> bool:
    """Whether its string `data` may be JSON."""
    kind = (fields_of(message) or {}).get("data")
    return isinstance(kind, definition.AbstractGenericString)


def _field(shape: Any, name: str) -> tuple[Any, Fault | None]:
    """What a field of a message is, or that there is none."""
    fields = fields_of(shape) or {}
    if name in fields:
        return shape_of(fields[name]), None
    return None, (f"{title(shape)} has no field '{name}'", near(name, list(fields)))


# ---- paths of fields


def faults_of_fields(conditions: Conditions, message: Any) -> Iterator[tuple[str, Fault]]:
    """(path, what is wrong with it) of the conditions that no such message fulfils."""
    for path, _ in conditions.fields:
        fault = _fault_of_path(path, message)
        if fault is not None:
            yield path, fault


def _fault_of_path(path: str, message: Any) -> Fault | None:
    shape = message
    fields = fields_of(message) or {}
    for name, index in STEP.findall(path):
        if shape is message and name and _has_json(message) and name not in fields:
            return None  # looked up in the JSON
        if fields_of(shape) is not None and name:
            shape, fault = _field(shape, name)
            if fault is not None:
                return fault
        elif isinstance(shape, Several) and index:
            shape = shape.element
        elif shape is None:
            return None
        else:
            asked = f"a field '{name}'" if name else f"an entry [{index}]"
            return f"'{path}' asks {title(shape)} for {asked}", None
    return None


# ---- expressions


def fault_of_expression(expression: Expression, message: Any) -> Fault | None:
    """The first field that it asks the message for and that is not there; None without one."""
    tree = ast.parse(expression.text.strip(), mode="eval").body
    names = {name.id for name in ast.walk(tree) if isinstance(name, ast.Name)}
    if "json" in names and not _has_json(message):
        hint = f"use m: {', '.join(fields_of(message) or ())}"
        return f"{title(message)} has no text 'data' that could be JSON", hint
    if any(isinstance(part, ast.NamedExpr) for part in ast.walk(tree)):
        return None  # names that mean something else from a part on that is hard to tell
    reader = _Reader()
    reader.shape(tree, {"m": message})
    return reader.faults[0] if reader.faults else None


class _Reader:
    """Follows an expression from the message to its fields."""

    def __init__(self) -> None:
        self.faults: list[Fault] = []

    def shape(self, node: ast.AST, names: Mapping[str, Any]) -> Any:
        """What a part of the expression is; None if that is not known."""
        match node:
            case ast.Name(id=name):
                return names.get(name)
            case ast.Attribute(value=value, attr=attr):
                return self._attribute(self.shape(value, names), attr)
            case ast.Subscript(value=value, slice=index):
                self.shape(index, names)
                return self._entry(self.shape(value, names), index)
            case ast.ListComp() | ast.SetComp() | ast.GeneratorExp() | ast.DictComp():
                return self._comprehension(node, dict(names))
            case ast.Lambda(args=args, body=body):
                own = {arg.arg: None for arg in ast.walk(args) if isinstance(arg, ast.arg)}
                return self._nothing(self.shape(body, {**names, **own}))
        for child in ast.iter_child_nodes(node):
            self.shape(child, names)
        return None

    def _nothing(self, shape: Any) -> None:
        """What a part is does not say what the whole is."""

    def _attribute(self, shape: Any, name: str) -> Any:
        if fields_of(shape) is not None:
            return self._noted(_field(shape, name))
        example: Any = [] if isinstance(shape, Several) else shape
        if shape is not None and not hasattr(example, name):
            self.faults.append((f"{title(shape)} has no '{name}'", None))
        return None

    def _entry(self, shape: Any, index: ast.AST) -> Any:
        if isinstance(shape, Several):
            return shape if isinstance(index, ast.Slice) else shape.element
        if fields_of(shape) is None or not isinstance(index, ast.Constant):
            return None
        return self._noted(_field(shape, str(index.value)))

    def _noted(self, found: tuple[Any, Fault | None]) -> Any:
        shape, fault = found
        if fault is not None:
            self.faults.append(fault)
        return shape

    def _comprehension(self, node: Any, names: dict[str, Any]) -> None:
        for part in node.generators:
            many = self.shape(part.iter, names)
            stored = (n.id for n in ast.walk(part.target) if isinstance(n, ast.Name))
            names |= dict.fromkeys(stored)
            if isinstance(part.target, ast.Name) and isinstance(many, Several):
                names[part.target.id] = many.element
            for condition in part.ifs:
                self.shape(condition, names)
        results = [node.key, node.value] if isinstance(node, ast.DictComp) else [node.elt]
        for result in results:
            self.shape(result, names)
