"""The log folder of one run, in ROS_LOG_DIR, ROS_HOME/log or ~/.ros/log.

| file | what |
|---|---|
| `launch.log` | all lines, of the launcher and of every process; `--log-file-name` |
| `NAME-N.log` | what one process wrote, stdout and stderr |
| `NAME-N-stdout.log`, `NAME-N-stderr.log` | one stream, where `output` is `own_log` or `full` |
| `events.jsonl` | starts, exits, restarts, signals (`event_log`) |
| `plan.json` | what the launch file has done, as in `plan --json` (launch/run_plan.py) |

The nodes write their own rclpy logs here too, since their ROS_LOG_DIR is this folder.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import functools
import os
import time
from collections.abc import Callable, Iterator, Mapping, MutableMapping

from launcher.base.model.spec import OutputPolicy, Sink
from launcher.output.lines import with_prefix, without_colour

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.output.logs.event_log import EventLog
    from launcher.output.logs.rotating_file import RotatingFile

NAME_BYTES = 240  # most file systems take 255, and rotation adds two
EVENTS = "events.jsonl"
MERGED = "launch.log"
PLAN = "plan.json"
# Large blocks are written to the merged file together, after a pass of the loop.
FLOOD_BYTES = 2048
MAX_TOGETHER = 64


def log_root(env: Mapping[str, str]) -> str:
    """The folder of all runs (CONFORMANCE 1.36), absolute: processes may have another directory."""
    return os.path.abspath(_named(env))


def _named(env: Mapping[str, str]) -> str:
    """As ROS 2 finds it; it begins with `~` if there is no home folder."""
    if env.get("ROS_LOG_DIR"):
        return os.path.expanduser(env["ROS_LOG_DIR"])
    ros_home = env.get("ROS_HOME") or os.path.join(env.get("HOME") or "~", ".ros")
    return os.path.join(os.path.expanduser(ros_home), "log")


def provide_log_root(
    env: MutableMapping[str, str], warn: Callable[[str], object] | None = None
) -> None:
    """If nothing can be written to that folder, have ROS_LOG_DIR lead to another.

    By default it warns on standard error.
    """
    if env.get("HOME") and _takes_files(log_root(env)):
        return  # nearly always, so that nothing is imported for it
    from launcher.posix import log_folder

    log_folder.provide(env, _named(env), *filter(None, [warn]))


def current_root(env: Mapping[str, str]) -> str:
    """Where a run that begins now would have its folder, and so the last one has had it."""
    if _takes_files(log_root(env)):
        return log_root(env)
    from launcher.posix import log_folder

    return log_folder.usable(env, _named(env))[0] or log_root(env)


def _takes_files(folder: str) -> bool:
    """Whether a file without a name can be made in it."""
    try:
        os.close(os.open(folder, os.O_TMPFILE | os.O_WRONLY | os.O_CLOEXEC, 0o600))
    except OSError as error:
        # Some file systems do not have such files.
        return error.errno == errno.EOPNOTSUPP and os.access(folder, os.W_OK | os.X_OK)
    return True


def new_run_path(env: Mapping[str, str], now_ns: int | None = None) -> str:
    """A folder for a run that begins now, named as ROS 2 names it (CONFORMANCE 1.1)."""
    # One reading of the clock: names are sorted by time, also across the end of a second.
    now_ns = time.time_ns() if now_ns is None else now_ns
    stamp = time.strftime("%Y-%m-%d-%H-%M-%S", time.localtime(now_ns // 10**9))
    micros = now_ns // 1000 % 1_000_000
    name = f"{stamp}-{micros:06d}-{os.uname().nodename}-{os.getpid()}"
    return os.path.join(log_root(env), name)


class RunDirectory:
    """Writes the files of a run; after an error it calls `on_trouble` once and writes no more.

    Call `keep_up()` regularly: it makes the directory again if it was removed. `path` is None if no
    directory is wanted, or it could not be made; then nothing is written. `soon(call)` calls after
    this pass of the loop. `name` is that of the merged file, and of the launcher's own lines in it.
    """

    def __init__(
        self,
        path: str | None,
        on_trouble: Callable[[str], None],
        *,
        soon: Callable[[Callable[[], None]], object] = lambda call: call(),
        name: str = "launch",
    ) -> None:
        self.name = name
        self._merged = f"{name}.log"
        self._on_trouble = on_trouble
        self._soon = soon
        self._together: list[bytes] = []
        self._collects = False
        self._files: dict[str, RotatingFile] = {}
        self._places: dict[tuple[str, str], tuple[bytes, tuple[str, ...]]] = {}
        self._broken = False
        self._lock = -1
        self.path: str | None = None
        if path is not None:
            self._make(path)

    @functools.cached_property
    def events(self) -> EventLog:
        from launcher.output.logs.event_log import EventLog  # not before there is an event

        return EventLog(lambda lines: self._append(EVENTS, lines))

    def _make(self, path: str) -> None:
        try:
            os.makedirs(path, exist_ok=True)  # a node may make it, too
            self._hold(path)
        except OSError as error:
            self._give_up(error)
            return
        self.path = path
        latest = os.path.join(os.path.dirname(path), "latest")
        try:
            _point(latest, path)
        except OSError as error:
            self._on_trouble(f"cannot link {latest}: {error.strerror}")

    def _hold(self, path: str) -> None:
        """Lock the events file, which marks the run as active."""
        before = self._lock
        self._lock = os.open(f"{path}/{EVENTS}", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        fcntl.flock(self._lock, fcntl.LOCK_EX)
        if before >= 0:
            os.close(before)

    def _hold_on(self, path: str) -> None:
        """Lock the events file again if it has been rotated."""
        with contextlib.suppress(OSError):  # then the next time
            if not os.path.samestat(os.stat(f"{path}/{EVENTS}"), os.fstat(self._lock)):
                self._hold(path)

    def keep_up(self) -> bool:
        """Make the directory again if it was removed; whether that was so, and succeeded."""
        if self.path is None or self._broken:
            return False
        if os.path.exists(f"{self.path}/{EVENTS}"):
            self._hold_on(self.path)
            return False
        self._close_files()
        self._make(self.path)
        if self._broken:
            return False
        text = f"{self.path} was removed: earlier logs are lost; made it again"
        self._on_trouble(text)
        self.log("WARNING", "launch", text)
        return True

    def log(self, level: str, logger: str, text: str) -> None:
        logger = self.name if logger == "launch" else logger
        line = f"{time.time():.7f} [{level}] [{logger}]: {text}\n"
        self._merge(without_colour(line.encode(errors="surrogateescape")))

    def log_line(self, line: str) -> None:
        """A line that is formatted already."""
        self._merge(f"{line}\n".encode(errors="surrogateescape"))

    def write_lines(
        self, name: str, policy: OutputPolicy, stream: str, lines: bytes, ago_s: float = 0.0
    ) -> None:
        """Write lines of a process that were read so many seconds ago."""
        if self.path is None or self._broken:
            return
        place = self._places.get((name, stream))
        if place is None:
            place = self._places[name, stream] = _place(name, policy, stream)
        prefix, files = place
        plain = without_colour(lines)
        prefixed = with_prefix(prefix, plain)  # first: the screen had the same just now
        self._merge(with_prefix(b"%.7f %b" % (time.time() - ago_s, prefix), plain))
        for file in files:
            self._append(file, prefixed)

    @contextlib.contextmanager
    def collecting(self) -> Iterator[None]:
        """Within, the lines of the merged file are collected, and written together."""
        self._collects = True
        try:
            yield
        finally:
            self._collects = False

    def write_plan(self, plan: Callable[[], object]) -> None:
        """Write `plan.json`, what was started so far."""
        self.keep_up()
        if self.path is None or self._broken:
            return
        from launcher.base import strict_json

        try:
            with open(f"{self.path}/{PLAN}", "w", encoding="utf-8") as file:
                file.write(strict_json.dumps(plan(), indent=1))
        except OSError as error:
            self._give_up(error)

    def close(self) -> None:
        self.events.flush()
        self._write_together()
        self._close_files()

    def _close_files(self) -> None:
        for file in self._files.values():
            file.close()
        self._files.clear()
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1

    def _merge(self, block: bytes) -> None:
        """Write to the merged file, in order."""
        if not self._together and len(block) < FLOOD_BYTES and not self._collects:
            self._append(self._merged, block)
            return
        self._together.append(block)
        if len(self._together) == 1:
            self._soon(self._write_together)
        elif len(self._together) == MAX_TOGETHER:
            self._write_together()

    def _write_together(self) -> None:
        blocks, self._together = self._together, []
        if blocks:
            self._append(self._merged, *blocks)

    def _append(self, name: str, *blocks: bytes) -> None:
        if self.path is None or self._broken:
            return
        try:
            file = self._files.get(name)
            if file is None:
                from launcher.output.logs.rotating_file import RotatingFile

                file = self._files[name] = RotatingFile(f"{self.path}/{_file_name(name)}")
            file.append(*blocks)
        except OSError as error:
            if isinstance(error, FileNotFoundError) and self.keep_up():
                self._append(name, *blocks)
            else:
                self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        self._broken = True
        self._on_trouble(
            f"no log files from here on: {error.strerror}: {error.filename or self.path}"
        )


def _place(name: str, policy: OutputPolicy, stream: str) -> tuple[bytes, tuple[str, ...]]:
    """(prefix in the common files, names of the separate files) for the lines of a stream."""
    sinks = policy.stderr if stream == "stderr" else policy.stdout
    own = (f"{name}-{stream}.log",) if Sink.OWN_LOG in sinks else ()
    return f"[{name}] ".encode(), (f"{name}.log", *own)


def _file_name(name: str) -> str:
    """A file name for this process; the number at its end keeps it unique."""
    name = name.replace("/", "_")
    if len(os.fsencode(name)) <= NAME_BYTES:
        return name
    return os.fsdecode(os.fsencode(name)[: NAME_BYTES // 2]) + name[-NAME_BYTES // 8 :]


def _point(link: str, target: str) -> None:
    """Make `link` point to `target`, atomically."""
    folder, name = os.path.split(link)
    fresh = os.path.join(folder, f".{name}-{os.getpid()}")
    with contextlib.suppress(FileNotFoundError):
        os.unlink(fresh)
    os.symlink(target, fresh)
    try:
        os.replace(fresh, link)
    except OSError:
        os.unlink(fresh)  # something else has this name
        raise
