"""A run with `--watch`, and the files that its nodes have loaded."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import psutil

from tests.support.children import children_with
from tests.support.controlled_run import ControlledRun
from tests.support.waiting import wait_until

if TYPE_CHECKING:
    from tests.support.benches import ControlBench

PROGRAM = """import signal
import sys
import time

import part

signal.signal(signal.SIGINT, lambda *args: sys.exit(0))
print(f"{sys.argv[1]} runs {part.VALUE}", flush=True)
time.sleep(1000)
"""


class Desk:
    """Nodes `a` and `b` that have loaded `part.py`, watched by a run."""

    def __init__(self, bench: ControlBench) -> None:
        self.bench = bench
        self.folder = bench.folder / "src"
        self.folder.mkdir()
        self.part = self.folder / "part.py"
        (self.folder / "node.py").write_text(PROGRAM)
        self.part.write_text("VALUE = 1\n")
        # Python compiles a file again only if its size, or the second of its change, is another.
        os.utime(self.part, (1e9, 1e9))

    def node(self, name: str, more: str = "") -> str:
        words = f'sys.executable, "{self.folder}/node.py", "{name}"'
        return f'ExecuteProcess(cmd=[{words}], name="{name}", output="screen"{more})'

    @property
    def nodes(self) -> str:
        return f"{self.node('a')}, {self.node('b')}"

    def run(self, actions: str | None = None, *words: str) -> ControlledRun:
        return self.bench.launch(actions or self.nodes, "--watch", *words)

    @property
    def launch_file(self) -> Path:
        return self.bench.folder / "bench.launch.py"


def is_watched(run: ControlledRun, *names: str) -> bool:
    rows = {row["name"].rpartition("-")[0]: row for row in run.ask("watch")["processes"]}
    return all(rows[name]["files"] for name in names)


def wait_for_watching(run: ControlledRun, *names: str) -> None:
    for name in names:
        run.wait_for(f"{name} runs 1")
    wait_until(lambda: is_watched(run, *names), "the files of all nodes")


def pids(run: ControlledRun) -> dict[str, int | None]:
    return {row["name"]: row["pid"] for row in run.ask("ps")["processes"]}


def watchers(run: ControlledRun) -> list[psutil.Process]:
    return children_with(run.process.pid, "launcher.run.watch")
