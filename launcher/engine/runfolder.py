"""RunFolder: the files of one run, below ROS_LOG_DIR, ROS_HOME/log or ~/.ros/log.

`launch.log` holds our own lines and those of processes whose output policy says `log`;
`own_log` gives a process files of its own. The nodes' rclpy logs land here too, because
ROS_LOG_DIR points here for them. Colour codes are left out.
"""

from __future__ import annotations

import contextlib
import os
import re
import socket
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from launcher.engine.lines import with_prefix
from launcher.model.spec import OutputPolicy, Sink

_COLOUR = re.compile(rb"\x1b\[[0-9;:]*m")


def log_root(env: Mapping[str, str]) -> Path:
    """Where runs are kept (CONFORMANCE 1.36)."""
    if env.get("ROS_LOG_DIR"):
        return Path(env["ROS_LOG_DIR"]).expanduser()
    if env.get("ROS_HOME"):
        return Path(env["ROS_HOME"]).expanduser() / "log"
    return Path(env.get("HOME", "~")).expanduser() / ".ros" / "log"


class RunFolder:
    """Writes the log files of a run; a disk that refuses is said once and then left alone.

    `path` is None where the folder could not be made; everything still works, without files.
    """

    def __init__(self, env: Mapping[str, str], on_trouble: Callable[[str], None]) -> None:
        self._on_trouble = on_trouble
        self._files: dict[str, int] = {}
        self._broken = False
        self.path: Path | None = None
        stamp = time.strftime("%Y-%m-%d-%H-%M-%S")
        micros = time.time_ns() // 1000 % 1_000_000
        name = f"{stamp}-{micros:06d}-{socket.gethostname()}-{os.getpid()}"
        path = log_root(env) / name
        try:
            path.mkdir(parents=True)
            _point(path.parent / "latest", path)
        except OSError as error:
            self._give_up(error)
            return
        self.path = path

    def log(self, level: str, logger: str, text: str) -> None:
        """A line of our own."""
        line = f"{time.time():.7f} [{level}] [{logger}]: {text}\n"
        self._append("launch.log", line.encode(errors="surrogateescape"))

    def write_lines(self, name: str, policy: OutputPolicy, stream: str, lines: bytes) -> None:
        """Whole lines of process `name`, to the files that its policy names for this stream."""
        sinks = policy.stderr if stream == "stderr" else policy.stdout
        own = Sink.OWN_LOG in sinks or Sink.OWN_LOG in policy.combined
        if not (own or Sink.LOG in sinks):
            return
        if b"\x1b" in lines:
            lines = _COLOUR.sub(b"", lines)
        prefix = f"[{name}] ".encode()
        if Sink.LOG in sinks:
            self._append("launch.log", with_prefix(f"{time.time():.7f} ".encode() + prefix, lines))
        if Sink.OWN_LOG in policy.combined:
            self._append(f"{name}.log", with_prefix(prefix, lines))
        if Sink.OWN_LOG in sinks:
            self._append(f"{name}-{stream}.log", with_prefix(prefix, lines))

    def close(self) -> None:
        """Close the files."""
        for fd in self._files.values():
            os.close(fd)
        self._files.clear()

    def _append(self, name: str, data: bytes) -> None:
        if self.path is None or self._broken:
            return
        try:
            if name not in self._files:
                flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC
                self._files[name] = os.open(self.path / name, flags, 0o644)
            while data:
                data = data[os.write(self._files[name], data) :]
        except OSError as error:
            self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        self._broken = True
        self._on_trouble(f"no log files from here on: {error.strerror}: {error.filename or 'disk'}")


def _point(link: Path, target: Path) -> None:
    """Make `link` point to `target`, in one step for whoever looks at the same moment."""
    fresh = link.with_name(f".{link.name}-{os.getpid()}")
    with contextlib.suppress(FileNotFoundError):
        fresh.unlink()
    fresh.symlink_to(target)
    fresh.replace(link)
