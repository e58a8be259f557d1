"""Which modules a command of the launcher imports."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from tests.support.repository import REPOSITORY

CODE = """
import os, runpy, sys

before = set(sys.modules)
{prologue}
sys.argv = ["launcher", *sys.argv[1:]]
try:
    runpy.run_module("launcher", run_name="__main__", alter_sys=True)
finally:
    sys.stdout.flush()
    with os.fdopen(os.dup(2), "w") as out:
        print(*(set(sys.modules) - before), file=out)
    os._exit(0)
"""


class LoadedModules(NamedTuple):
    """Those that a command has imported at its end, and all of its standard error."""

    names: set[str]
    errors: str


def loaded_modules(
    *words: str, options: Sequence[str] = (), prologue: str = "", **variables: str
) -> LoadedModules:
    """Of the launcher with these words, in a Python with these options that runs `prologue`."""
    done = subprocess.run(
        [sys.executable, *options, "-c", CODE.format(prologue=prologue), *words],
        cwd=REPOSITORY,
        env={**os.environ, "PYTHONPATH": str(REPOSITORY), **variables},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return LoadedModules(set(done.stderr.splitlines()[-1].split()), done.stderr)


def loaded_by_run(file: Path) -> set[str]:
    """By a whole run of this launch file, in a Python without site-packages."""
    # A domain above 99 is looked at more closely, which imports more.
    words = (str(file), "--no-log-files")
    return loaded_modules(*words, options=["-S"], ROS_DOMAIN_ID="0").names
