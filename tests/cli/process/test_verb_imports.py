"""What verbs import: what they use, and nothing that takes long to import."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from tests.support.repository import REPOSITORY

# Each takes 3 to 30 ms.
LARGE = {
    *("dataclasses", "email.message", "hashlib", "importlib.metadata", "inspect", "psutil"),
    *("rclpy", "urllib.request", "xml.etree.ElementTree", "yaml"),
}
CODE = """
import os, runpy, sys

before = set(sys.modules)
sys.argv = ["launcher", *sys.argv[1:]]
try:
    runpy.run_module("launcher", run_name="__main__", alter_sys=True)
finally:
    sys.stdout.flush()
    with os.fdopen(os.dup(2), "w") as out:
        print(*(set(sys.modules) - before), file=out)
    os._exit(0)
"""


@pytest.mark.parametrize(
    ("words", "used", "most"),
    [
        ("--help", set(), 70),
        ("ps", set(), 70),
        ("topic list --help", {"dataclasses", "inspect"}, 50),
        ("pkg list", set(), 35),
        ("smoke --help", set(), 45),
        ("plan system", set(), 130),
        ("launch --help", set(), 40),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_verb_imports_what_it_uses(words: str, used: set[str], most: int):
    env = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    done = subprocess.run(
        [sys.executable, "-c", CODE, *words.split()],
        cwd=REPOSITORY,
        env=env,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    modules = set(done.stderr.splitlines()[-1].split())
    assert modules & LARGE == used
    ours = sorted(name for name in modules if name.partition(".")[0] == "launcher")
    assert len(ours) <= most, ours
