"""The operator's computer, on which the launcher runs."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tests.support.hosts.boot import Boot
from tests.support.hosts.computer import Computer
from tests.support.hosts.network import Port


class Operator(Computer):
    """Has no sshd. It shares pids, /tmp and /run with the machine, so tests can signal and read."""

    def __init__(self, port: Port, folder: Path) -> None:
        super().__init__("operator", port, folder, folder / "home")
        self.home.mkdir(mode=0o755, parents=True)
        self.runtime = folder / "run"
        self.runtime.mkdir(mode=0o700)
        self._boot = Boot(self.name, self.home, folder, port, is_host=False)
        self.pid, self.own_pids = self._boot.pid, self._boot.pids

    def environment(self, env: Mapping[str, str] | None = None) -> dict[str, str]:
        own = {
            "PATH": f"{Path(sys.executable).parent}:{super().environment()['PATH']}",
            "XDG_RUNTIME_DIR": str(self.runtime),
            "XDG_STATE_HOME": str(self.home / ".local/state"),
        }
        if "ROS_DOMAIN_ID" in os.environ:
            own["ROS_DOMAIN_ID"] = os.environ["ROS_DOMAIN_ID"]
        return {**super().environment(), **own, **(env or {})}

    def close(self) -> None:
        self._boot.end()

    def launcher(self, *words: object, **options: Any) -> Any:
        """`python -m launcher WORDS`, to its end, whatever its exit code; see `run`."""
        return self.run(launcher_words(words), **{"check": False, **options})


def launcher_words(words: Sequence[object]) -> list[str]:
    return [sys.executable, "-m", "launcher", *map(str, words)]
