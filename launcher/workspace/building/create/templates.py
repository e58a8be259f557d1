"""The files of new packages, from the folder `templates`."""

from __future__ import annotations

import string
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.resources import files
from xml.sax.saxutils import escape

from launcher.base import strict_json

_OF_NODES = ("rclpy", "rcl_interfaces")  # what the example nodes import besides their types
_OF_INTERFACES = ("builtin_interfaces",)


@dataclass(frozen=True, kw_only=True)
class PackageMetadata:
    """What package.xml and setup.py say about a package; a line each."""

    description: str
    license: str
    maintainer: str
    email: str


class _Template(string.Template):
    delimiter = "@@"


def node_files(
    name: str,
    nodes: Sequence[str],
    metadata: PackageMetadata,
    *,
    dependencies: Sequence[str] = (),
    interfaces: str | None = None,
) -> dict[str, str]:
    """Path -> text of a package of nodes; these use the types of the package `interfaces`."""
    values = {
        **_common(name, metadata, (*_OF_NODES, interfaces or "std_msgs", *dependencies)),
        **_types(interfaces),
        **{f"py_{key}": _quoted(value) for key, value in vars(metadata).items()},
        "console_scripts": _lines((f'"{node} = {name}.{node}:main",' for node in nodes), 12),
        "node_list": _quoted(list(nodes)),
        "node_imports": _lines(f"from {name}.{n} import {class_name(n)}" for n in sorted(nodes)),
        "node_classes": f"[{', '.join(map(class_name, nodes))}]",
    }
    node_template = "node_of_own_types.py" if interfaces else "node.py"
    named = [{**values, "node": node, "class_name": class_name(node)} for node in nodes]
    return {
        "package.xml": _render("nodes/package.xml", values),
        "setup.py": _render("nodes/setup.py", values),
        "setup.cfg": _render("nodes/setup.cfg", values),
        f"resource/{name}": "",
        f"{name}/__init__.py": "",
        **{f"{name}/{one['node']}.py": _render(f"nodes/{node_template}", one) for one in named},
        f"launch/{name}.launch.py": _render("nodes/launch.py", values),
        f"test/test_{name}.py": _render("nodes/test.py", values),
        f"test/test_{name}_launch.py": _render("nodes/launch_test.py", values),
    }


def interface_files(
    name: str, metadata: PackageMetadata, *, dependencies: Sequence[str] = ()
) -> dict[str, str]:
    """Path -> text of a package of a message, a service and an action."""
    needed = tuple(dict.fromkeys((*_OF_INTERFACES, *dependencies)))
    values = {
        **_common(name, metadata, needed),
        "find_packages": _lines(f"find_package({one} REQUIRED)" for one in needed),
        "dependencies": " ".join(needed),
    }
    return {
        "package.xml": _render("interfaces/package.xml", values),
        "CMakeLists.txt": _render("interfaces/CMakeLists.txt", values),
        "msg/Count.msg": _render("interfaces/Count.msg", values),
        "srv/ResetCount.srv": _render("interfaces/ResetCount.srv", values),
        "action/CountTo.action": _render("interfaces/CountTo.action", values),
        f"test/test_{name}.py": _render("interfaces/test.py", values),
    }


def class_name(node: str) -> str:
    """`RobotArmNode` for the node `robot_arm`; never rclpy's `Node`."""
    words = node.split("_")
    if len(words) > 1 and words[-1] == "node":
        words.pop()
    return "".join(word.capitalize() for word in words) + "Node"


def _common(name: str, metadata: PackageMetadata, needed: Iterable[str]) -> dict[str, str]:
    depends = _lines((f"<depend>{one}</depend>" for one in dict.fromkeys(needed)), 2)
    quoted = {f"xml_{k}": escape(v, {'"': "&quot;"}) for k, v in vars(metadata).items()}
    return {"name": name, "depends": depends, **quoted}


def _types(interfaces: str | None) -> dict[str, str]:
    """What the tests and nodes use: a type of std_msgs, or the examples of an own package."""
    if interfaces is None:
        message_import = "from std_msgs.msg import UInt64"
        return {"type_imports": message_import, "message": "UInt64", "field": "data", "service": ""}
    imports = (f"from {interfaces}.msg import Count", f"from {interfaces}.srv import ResetCount")
    return {
        "interfaces": interfaces,
        "type_imports": _lines(("", *imports)),
        "message": "Count",
        "field": "count",
        "service": _render("nodes/service_test.py", {}),
    }


def _render(template: str, values: dict[str, str]) -> str:
    source = files("launcher.workspace.building.create").joinpath(f"templates/{template}.in")
    text = _Template(source.read_text(encoding="utf-8")).substitute(values)
    return f"{text.rstrip()}\n"


def _lines(lines: Iterable[str], indent: int = 0) -> str:
    return "\n".join(f"{'':{indent}}{line}" if line else "" for line in lines)


def _quoted(value: str | list[str]) -> str:
    """As a literal of Python, with the quotes that its formatters prefer."""
    return strict_json.dumps(value, ensure_ascii=False)
