"""Messages on standard output stay whole whatever libraries in C print."""

from __future__ import annotations

import ast
import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import json, os, sys, threading
from launcher.posix.stdio import keep_for_messages

def print_as_c_does():
    for number in range(2000):
        os.write(1, b"pieces "), os.write(1, b"of lines\\n")

keep_for_messages()
thread = threading.Thread(target=print_as_c_does)
thread.start()
for number in range(2000):
    print(json.dumps({"number": number, "text": "é"}), flush=True)
thread.join()
os.system("echo of a child; ls -l /proc/self/fd | grep -c pipe:")
"""


def test_messages_have_a_descriptor_of_their_own():
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=60, check=True
    )
    numbers = [json.loads(line)["number"] for line in done.stdout.splitlines()]
    assert numbers == list(range(2000))
    assert done.stderr.count("pieces of lines\n") == 2000
    assert "of a child\n2\n" in done.stderr, "ls has those to grep and of standard error"


# What has an rclpy node, and answers the launcher, smoke or the page by lines of JSON.
HELPERS = (
    "bag.ros.flight",
    "ros.helpers.agent",
    "ros.helpers.logger_levels",
    "ros.helpers.parameter_check",
    "ros.helpers.responsiveness",
    "ros.probe",
    "ros.ready",
)


@pytest.mark.parametrize("name", HELPERS)
def test_helpers_keep_their_standard_output_for_messages(name: str):
    spec = importlib.util.find_spec(f"launcher.{name}")
    assert spec is not None and spec.origin is not None
    path = Path(spec.origin)
    if path.name == "__init__.py":
        path = path.with_name("__main__.py")
    main = next(
        node
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and node.name == "main"
    )
    assert "keep_for_messages()" in [ast.unparse(node) for node in main.body]
