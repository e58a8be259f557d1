"""Entry points and node classes are in modules of their own, and use rclpy's public interface."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from tests.support.repository import REPOSITORY

PACKAGE = REPOSITORY / "group_gp1"
ENTRY_POINTS = {"dispatcher", "monitor", "debug_logger", "qos_probe"}
ENTRY_POINTS |= {"robot", "robot_1", "robot_2", "robot_3"}
STOPS = {"KeyboardInterrupt", "ExternalShutdownException"}


def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def classes_of(path: Path) -> list[ast.ClassDef]:
    return [one for one in ast.walk(tree_of(path)) if isinstance(one, ast.ClassDef)]


def functions_of(path: Path) -> dict[str, ast.FunctionDef]:
    return {one.name: one for one in tree_of(path).body if isinstance(one, ast.FunctionDef)}


@pytest.mark.parametrize("name", sorted(ENTRY_POINTS))
def test_an_entry_point_has_no_class_and_cleans_up(name: str):
    path = PACKAGE / f"{name}.py"
    assert classes_of(path) == []
    block = next(one for one in functions_of(path)["main"].body if isinstance(one, ast.Try))
    assert {word.id for word in ast.walk(block.handlers[0]) if isinstance(word, ast.Name)} >= STOPS
    [guard] = block.finalbody
    assert isinstance(guard, ast.If)
    assert ast.unparse(guard) == "if rclpy.ok():\n    rclpy.try_shutdown()"


def test_each_module_of_nodes_has_one_node_class_and_no_main():
    modules = sorted((PACKAGE / "nodes").glob("*_node.py"))
    assert len(modules) == len(ENTRY_POINTS) - 3  # the robots share one
    for path in modules:
        nodes = [one.name for one in classes_of(path) if "Node" in map(ast.unparse, one.bases)]
        assert [one.lower() for one in nodes] == [path.stem.removesuffix("_node").replace("_", "")]
        assert "main" not in functions_of(path)


def test_setup_py_installs_each_entry_point():
    setup = (REPOSITORY / "setup.py").read_text(encoding="utf-8")
    lists = [one for one in ast.walk(ast.parse(setup)) if isinstance(one, ast.Assign)]
    [nodes] = [one.value for one in lists if ast.unparse(one.targets[0]) == "NODES"]
    assert set(ast.literal_eval(nodes)) == ENTRY_POINTS


def imported_by(path: Path) -> set[str]:
    found: set[str] = set()
    for one in ast.walk(tree_of(path)):
        if isinstance(one, ast.Import):
            found |= {name.name for name in one.names}
        elif isinstance(one, ast.ImportFrom):
            found |= {f"{one.module}.{name.name}" for name in one.names}
    return found


def test_nothing_of_rclpy_that_is_private_is_imported():
    for path in PACKAGE.rglob("*.py"):
        private = {one for one in imported_by(path) if one.startswith(("rclpy.impl", "rclpy._"))}
        assert private == set(), path


def test_the_logic_needs_no_ros():
    modules = list((PACKAGE / "logic").glob("*.py"))
    assert len(modules) > 5
    ros = ("rclpy", "std_msgs", "group_gp1.nodes", "group_gp1.qos", "group_gp1.settings")
    for path in modules:
        assert {one for one in imported_by(path) if one.startswith(ros)} == set(), path
