"""`python -m tests.support.parameter_printer`: a node that prints the parameters it was given."""

from __future__ import annotations

import json

import rclpy
from rclpy.node import Node

BUILT_IN = ("use_sim_time", "start_type_description_service")


def main() -> None:
    rclpy.init()
    node = Node("printer", automatically_declare_parameters_from_overrides=True)
    given = node.get_parameters_by_prefix("")
    values = {name: one.value for name, one in given.items() if name not in BUILT_IN}
    name = node.get_fully_qualified_name()
    print(json.dumps({"node": name, "parameters": values}, default=list), flush=True)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
