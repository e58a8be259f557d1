"""A real run that is controlled over its socket; its screen output goes into a file."""

from __future__ import annotations

import fnmatch
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import psutil

from launcher.control.client import Connection
from tests.support.json_forms import fit_result
from tests.support.waiting import rest_of, wait_until

TIMEOUT_S = 60.0


class ControlledRun:
    """A running launcher that listens at `socket`. Use `with`: it is killed at the end."""

    def __init__(
        self,
        command: Sequence[str],
        *,
        env: Mapping[str, str],
        runtime: Path,
        screen: Path,
        files: int | None = None,
    ) -> None:
        self.screen_path = screen
        self._runtime = runtime
        # Runs of others on this machine are not seen: their sockets may be below /tmp, or below the
        # folder that all tests were started with.
        inherited = os.environ.get("TMPDIR")
        chosen = {k: v for k, v in env.items() if k != "TMPDIR" or v != inherited}
        self.env = {"TMPDIR": str(runtime), **chosen, "XDG_RUNTIME_DIR": str(runtime)}
        limits = (files, files)
        with open(screen, "wb") as file:
            self.process = subprocess.Popen(
                command,
                env=self.env,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                preexec_fn=None
                if files is None
                else lambda: resource.setrlimit(resource.RLIMIT_NOFILE, limits),
            )

    def __enter__(self) -> ControlledRun:
        return self

    def __exit__(self, *exc: object) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    # ---- its socket

    @property
    def socket(self) -> Path:
        """Where it listens, as soon as it does."""
        found: list[Path] = []

        def is_there() -> bool:
            found[:] = self.sockets()
            return bool(found)

        wait_until(is_there, f"a socket of {self.process.pid}; screen:\n{self.screen}")
        return found[0]

    def sockets(self) -> list[Path]:
        """One while it listens; none is left when it has ended."""
        return sockets_below(self._runtime, str(self.process.pid))

    def connect(self) -> Connection:
        return Connection(self.socket, timeout_s=TIMEOUT_S)

    def ask(self, verb: str, *names: str, **options: Any) -> dict[str, Any]:
        """The result of a verb, asked over a separate connection."""
        with self.connect() as connection:
            result = connection.ask(verb, names, timeout_s=TIMEOUT_S, **options).result
        fit_result(verb, result)
        return result

    def ask_text(self, verb: str, *names: str, **options: Any) -> str:
        """The text that a verb prints."""
        with self.connect() as connection:
            return "\n".join(connection.ask(verb, names, timeout_s=TIMEOUT_S, **options).text)

    def row(self, name: str) -> dict[str, Any]:
        """A process as `ps` sees it."""
        (row,) = self.ask("ps", name)["processes"]
        return row

    def shell(self, *words: str) -> subprocess.CompletedProcess[str]:
        """A command from another shell, to its end."""
        command = self.shell_start(*words)
        out, err = rest_of(command, TIMEOUT_S)
        return subprocess.CompletedProcess(command.args, command.returncode, out, err)

    def shell_start(self, *words: str) -> subprocess.Popen[str]:
        """A command from another shell, when the run listens."""
        assert self.process.poll() is not None or self.socket
        return subprocess.Popen(
            [sys.executable, "-m", "launcher", *words],
            env=self.env,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    # ---- what can be seen of it

    @property
    def screen(self) -> str:
        """All that it has shown so far."""
        return self.screen_path.read_text(encoding="utf-8", errors="replace")

    def wait_for(self, text: str) -> None:
        """Wait until it has shown this."""
        wait_until(lambda: text in self.screen, f"{text!r} on the screen:\n{self.screen}")

    def wait_for_log(self, name: str, text: str) -> None:
        """Wait until a process has written this, shown or not."""
        wait_until(
            lambda: any(text in line["text"] for line in self.ask("logs", name)["lines"]),
            f"{text!r} from {name}",
        )

    @property
    def log(self) -> str:
        """`launch.log`."""
        with self.connect() as connection:
            folder = Path(connection.hello["run"]["log_dir"])
        return (folder / "launch.log").read_text(encoding="utf-8")

    def exit_code(self) -> int:
        """Wait for its end."""
        return self.process.wait(TIMEOUT_S)

    def open_files(self) -> int:
        """How many descriptors the launcher holds."""
        return psutil.Process(self.process.pid).num_fds()


def sockets_below(folder: Path, run: str = "*") -> list[Path]:
    """Sockets of runs, in folders of which others come and go."""
    return [
        Path(where, name)
        for where, _, names in os.walk(folder)
        for name in fnmatch.filter(names, f"{run}-*.sock")
    ]


def state_of(pid: int) -> str:
    """`sleeping`, `stopped` and so on, as psutil has them; empty if it is gone."""
    try:
        return psutil.Process(pid).status()
    except psutil.NoSuchProcess:
        return ""
