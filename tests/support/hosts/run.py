"""A run of the launcher on the operator's computer, with its lines."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tests.support.children import children, children_named
from tests.support.hosts.host import Host
from tests.support.hosts.lab import Lab
from tests.support.repository import REPOSITORY
from tests.support.waiting import wait_until

# Counts with its time, and does what the rest of its words say.
COUNT = (
    "import time, sys\n"
    "n = 0\n"
    "while True:\n"
    "    print(n, repr(time.monotonic()), flush=True)\n"
    "    n += 1\n"
    "    time.sleep(float(sys.argv[1]))\n"
)
_LAUNCH = """\
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess


def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=[sys.executable, "-c", {code!r}, {pause!r}], name=name, output="screen")
        for name in {names!r}
    ])
"""


class Run:
    """Use `with`; ends the launcher if it still runs."""

    def __init__(
        self,
        lab: Lab,
        folder: Path,
        hosts: Mapping[Host, Mapping[str, Any]],
        place: Mapping[str, str],
        *,
        code: str = COUNT,
        pause: str = "0.01",
        words: Sequence[str] = (),
    ) -> None:
        launch = folder / "count.launch.py"
        launch.write_text(_LAUNCH.format(code=code, pause=pause, names=[*place]))
        settings = {host: {"engine": "ssh", **fields} for host, fields in hosts.items()}
        rules = dict(place)
        file = lab.hosts_file(folder / "hosts.yaml", settings, rules)
        command = [sys.executable, "-m", "launcher", str(launch), "--hosts", str(file), *words]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        self.process = lab.operator.popen(command, cwd=REPOSITORY, **pipes)
        self.lines: list[str] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line.rstrip("\n"))

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *exc: object) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
        self.process.wait()
        self._reader.join()

    @property
    def text(self) -> str:
        return "\n".join(self.lines)

    def wait_for(self, pattern: str, *, after: int = 0) -> int:
        """Wait for a line with the pattern, from the line `after` on; the number of the next."""
        found: list[int] = []

        def is_there() -> bool:
            has_ended = self._has_ended()  # before the lines are looked at
            for number, line in enumerate(self.lines[after:], after):
                if re.search(pattern, line):
                    found.append(number + 1)
                    return True
            assert not has_ended, self.text[-3000:]
            return False

        try:
            wait_until(is_there, pattern)
        except AssertionError as error:
            raise AssertionError(f"{error}\n{self.text[-3000:]}") from None
        return found[0]

    def _has_ended(self) -> bool:
        """Whether it has, and all its lines are there."""
        return self.process.poll() is not None and not self._reader.is_alive()

    def interrupt(self) -> None:
        self.process.send_signal(signal.SIGINT)

    def end(self) -> int:
        """Its exit code."""
        code = self.process.wait(60)
        self._reader.join()
        return code

    def stop(self) -> int:
        self.interrupt()
        return self.end()

    def counted(self, name: str) -> list[tuple[int, float]]:
        """(number, time of the host) of each line of a counting process."""
        pattern = re.compile(rf"\[{re.escape(name)}-\d+\] (\d+) ([\d.]+)$")
        found = (pattern.match(line) for line in self.lines)
        return [(int(match[1]), float(match[2])) for match in found if match]

    def ssh_pids(self) -> list[int]:
        """The processes that lead to hosts."""
        return children_named(self.process.inside, "ssh")


def agents(host: Host) -> list[int]:
    """Pids of agents on a host, without the processes that hold their sessions."""
    words = ("-m", "launcher", "agent")
    found = {process.pid for process in host.processes() if process.words[1:] == words}
    return [pid for pid in found if not found & set(children(pid))]


def rest(host: Host) -> list[tuple[str, ...]]:
    """What runs on a host besides the sshd that listens."""
    found = [each.words for each in host.processes()]
    return [words for words in found if "[listener]" not in words[0]]


def is_clean(host: Host) -> bool:
    """Whether nothing of a run is left: no process, file or socket."""
    files = host.run(["find", "/tmp", "-mindepth", "1", "-not", "-type", "d"]).stdout
    return not rest(host) and not files.strip()
