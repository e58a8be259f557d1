"""`python -m tests.support.parameter_printer`: a node that prints the parameters it was given."""

from __future__ import annotations

import json
from typing import Any

import rclpy
from rclpy.node import Node

BUILT_IN = ("use_sim_time", "start_type_description_service")


def given(node: Node) -> dict[str, Any]:
    """The values of the parameters that a node was given."""
    found = node.get_parameters_by_prefix("")
    return {name: one.value for name, one in found.items() if name not in BUILT_IN}


def main() -> None:
    rclpy.init()
    node = Node("printer", automatically_declare_parameters_from_overrides=True)
    name = node.get_fully_qualified_name()
    print(json.dumps({"node": name, "parameters": given(node)}, default=list), flush=True)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
