"""Facts: what the doctor saw, as plain values. What they mean is decided in `checks`."""

from __future__ import annotations

import enum

from launcher.engine.monitor.shared_memory import Stale
from launcher.model.record import Record


class Level(enum.Enum):
    """How bad a finding is; only a problem makes the doctor's exit code 1."""

    OK = "ok"
    NOTE = "note"
    PROBLEM = "problem"


class Finding(Record):
    """What one check says: a noun, one sentence, and what to do where that is needed."""

    name: str
    level: Level
    text: str
    advice: str | None = None
    fixable: bool = False  # by `doctor --fix`


class Leftover(Record):
    """A process that has outlived its launcher; `command` is its command line."""

    run_id: str
    pid: int
    command: str


class Unreachable(Record):
    """A process whose own files in /dev/shm somebody has removed while it lives."""

    pid: int
    command: str


class Space(Record):
    """How large a file system is."""

    total_bytes: int
    free_bytes: int


class Prefix(Record):
    """An entry of AMENT_PREFIX_PATH. `hides`: packages of the wheels that it has, too, first."""

    path: str
    exists: bool
    hides: tuple[str, ...] = ()


class Facts(Record):
    """Everything that the checks want to know. None where there is no such thing."""

    stale: tuple[Stale, ...]
    leftovers: tuple[Leftover, ...]
    unreachable: tuple[Unreachable, ...]
    shared_memory: Space | None
    import_errors: dict[str, str]  # module -> why it cannot be imported
    prefixes: tuple[Prefix, ...]
    python_prefix: str
    is_bootstrapped: bool  # _ROS_WHEELS_BOOTSTRAP_COMPLETE is set
    library_path: tuple[str, ...]  # the entries of LD_LIBRARY_PATH
    version: str
    folder: str  # where the launcher that runs comes from
    installed_version: str | None
    domain_id: str | None  # ROS_DOMAIN_ID as it is written
    log_folder: str
    log_obstacle: str | None  # what keeps us from writing there
    open_files: int  # the soft limit
    open_files_hard: int
