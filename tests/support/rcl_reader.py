"""`python -m tests.support.rcl_reader`: what rcl reads for nodes from parameter files.

Standard input is a JSON list of `[text of a file, namespace, name of a node]`; for each, the names
and values of the parameters that the node gets are printed as JSON.
"""

from __future__ import annotations

import json
import sys
import tempfile
from typing import Any

import rclpy

from tests.support.parameter_printer import given


def read(text: str, namespace: str, name: str) -> Any:
    with tempfile.NamedTemporaryFile("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        node = rclpy.create_node(
            name,
            namespace=namespace,
            cli_args=["--ros-args", "--params-file", file.name],
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
            automatically_declare_parameters_from_overrides=True,
        )
    found = given(node)
    node.destroy_node()
    return found


def main() -> None:
    rclpy.init(args=[])
    print(json.dumps([read(*words) for words in json.load(sys.stdin)]))
    rclpy.shutdown()


if __name__ == "__main__":
    main()
