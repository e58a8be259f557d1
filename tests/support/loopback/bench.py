"""Runs of the launcher with loopback hosts, and their switches."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from tests.process.conftest import ControlBench
from tests.support.loopback.run import SWITCHES


class HostsBench(ControlBench):
    """Processes run on the host that their names begin with: `bot1_talker` on `bot1`."""

    HOSTS = ("bot1", "bot2", "refuses1", "missing1", "silent1", "leashed")

    def __init__(self, folder: Path, runtime: Path) -> None:
        super().__init__(folder, runtime)
        self.fifo = folder / "switches"
        os.mkfifo(self.fifo)
        self.env[SWITCHES] = str(self.fifo)
        self.hosts = folder / "hosts.yaml"
        entries = "".join(f"  {name}: {{address: 127.0.0.1}}\n" for name in self.HOSTS[:-1])
        leashed = "  leashed: {address: 127.0.0.1, on_link_loss: stop-after=0.2}\n"
        rules = "".join(f"  '{name}_*': {name}\n" for name in self.HOSTS)
        self.hosts.write_text(f"hosts:\n{entries}{leashed}place:\n{rules}", encoding="utf-8")

    def command(self, actions: str, *words: str) -> Sequence[str]:
        python, _, _, file, *rest = super().command(actions, *words)
        runner = [python, "-m", "tests.support.loopback.run", file]
        return [*runner, "--hosts", str(self.hosts), *rest]

    def switch(self, line: str) -> None:
        """`cut bot1`, `restore bot1`, `power_off bot1`."""
        with open(self.fifo, "w", encoding="utf-8") as fifo:
            fifo.write(f"{line}\n")
