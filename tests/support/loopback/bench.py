"""Runs of the launcher with loopback hosts, and their switches."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun
from tests.support.loopback.run import SWITCHES
from tests.support.waiting import wait_until

HOSTS = ("bot1", "bot2", "refuses1", "missing1", "silent1", "leashed")
SLEEPER = 'sh("exec sleep 1000", name="{}")'
FLEET = ",".join(SLEEPER.format(name) for name in ("bot1_a", "bot2_b", "here"))
COUNTER = 'sh("i=0; while :; do i=$((i+1)); echo count $i; sleep 0.05; done", name="bot1_counter")'


class HostsBench(ControlBench):
    """Processes run on the host that their names begin with: `bot1_talker` on `bot1`.

    `leashed` stops its processes 1 s after its link was lost.
    """

    def __init__(self, folder: Path, runtime: Path) -> None:
        super().__init__(folder, runtime)
        self.fifo = folder / "switches"
        os.mkfifo(self.fifo)
        self.env[SWITCHES] = str(self.fifo)
        self.hosts = folder / "hosts.yaml"
        self.hosts_text: str | None = None  # instead of the usual one

    def command(self, actions: str, *words: str) -> Sequence[str]:
        self.hosts.write_text(self.hosts_text or _hosts_file(actions), encoding="utf-8")
        python, _, _, file, *rest = super().command(actions, *words)
        runner = [python, "-m", "tests.support.loopback.run", file]
        return [*runner, "--hosts", str(self.hosts), *rest]

    def switch(self, line: str) -> None:
        """`cut bot1`, `restore bot1`, `power_off bot1`."""
        with open(self.fifo, "w", encoding="utf-8") as fifo:
            fifo.write(f"{line}\n")


def is_running(run: ControlledRun, name: str) -> bool:
    return run.row(name)["state"] == "RUNNING"


def wait_for_fleet(run: ControlledRun) -> None:
    names = ("bot1_a", "bot2_b", "here")
    wait_until(lambda: all(is_running(run, name) for name in names), "a running fleet")


def events(run: ControlledRun) -> list[dict[str, Any]]:
    return run.ask("events")["events"]


def _hosts_file(actions: str) -> str:
    """With rules for the hosts that the actions name."""
    leash = {"leashed": ", on_link_loss: stop-after=1"}
    hosts = [f"  {name}: {{address: 127.0.0.1{leash.get(name, '')}}}" for name in HOSTS]
    rules = [f"  '{name}_*': {name}" for name in HOSTS if f"{name}_" in actions]
    return "\n".join(["hosts:", *hosts, *(["place:"] if rules else []), *rules, ""])
