"""Facts about this machine, and the findings of the checks, as plain data."""

from __future__ import annotations

from launcher.base.model.level import Level
from launcher.base.model.record import Record
from launcher.packages.byte_code import Uncached
from launcher.run.monitor.shared_memory import Stale


class Finding(Record):
    """The result of a check; `advice` says what to do."""

    name: str
    level: Level
    text: str
    advice: str | None = None
    fixable: bool = False  # by `doctor --fix`


class Leftover(Record):
    """A process that has outlived its launcher."""

    run_id: str
    pid: int
    command: str


class Unreachable(Record):
    """A running process whose files in /dev/shm were removed."""

    pid: int
    command: str


class Space(Record):
    total_bytes: int
    free_bytes: int


class Prefix(Record):
    """An entry of AMENT_PREFIX_PATH; `hides` are packages of the wheels that it shadows."""

    path: str
    exists: bool
    hides: tuple[str, ...] = ()


class WorkspaceFacts(Record):
    """A workspace; by the name of the package: what is stale, and what is there twice.

    `build` is the command that builds it; `error` is why its environment cannot be read.
    """

    root: str
    build: str
    is_merged: bool = False  # all packages share one prefix
    error: str | None = None
    scripts: tuple[str, ...] = ()  # hooks without data, which are not run
    missing_underlays: tuple[str, ...] = ()
    changed: dict[str, str] = {}  # why it must be built
    cleaned: tuple[str, ...] = ()  # whose old results a build removes by itself
    moved_from: str | None = None  # another workspace, which links of this one lead to
    broken: dict[str, str] = {}  # the missing folder in build/ that installed links lead to
    gone: tuple[str, ...] = ()  # installed, without a source
    dead: tuple[str, ...] = ()  # of these, the ones with links to their source
    other_python: dict[str, str] = {}  # the version that it is installed for
    no_interpreter: dict[str, str] = {}  # the missing interpreter of a program
    twice: dict[str, tuple[str, ...]] = {}  # its folders in src/
    hides: dict[str, str] = {}  # the prefix in the environment that has it as well


class ParticipantProcess(Record):
    """A process on this machine that holds the ports of a participant of DDS.

    `shares_memory` is whether its /dev/shm is that of this process; None if that is not known.
    """

    pid: int
    command: str
    domain: int
    settings: dict[str, str] = {}
    shares_memory: bool | None = None


class SettingsFacts(Record):
    """Variables of ROS and of the middleware, if they are not empty.

    `faults` has why what a variable names cannot be read; `refusal` is why the verbs refuse the
    environment, with the hint.
    """

    values: dict[str, str] = {}
    faults: dict[str, str] = {}
    refusal: tuple[str, str] | None = None
    has_fast_dds_3: bool = False


class NetworkFacts(Record):
    """About discovery; `settings` are the variables that decide it, if they are not empty."""

    settings: dict[str, str] = {}
    unknown_peers: tuple[str, ...] = ()  # names in ROS_STATIC_PEERS that cannot be resolved
    unknown_servers: tuple[str, ...] = ()  # entries of ROS_DISCOVERY_SERVER that are no address
    loopback_fault: str | None = None  # why 127.0.0.1 cannot be reached
    addresses: tuple[str, ...] = ()  # of this machine, without the loopback interface
    without_multicast: tuple[str, ...] = ()  # of these, where a datagram does not come back
    is_in_step: bool | None = None  # the clock
    nodes: tuple[ParticipantProcess, ...] = ()


class DoctorFacts(Record):
    """The input of the checks; None for what does not exist."""

    stale: tuple[Stale, ...]
    leftovers: tuple[Leftover, ...]
    stale_groups: tuple[str, ...]  # control groups of runs whose launcher has exited
    unreachable: tuple[Unreachable, ...]
    shared_memory: Space | None
    ros: str | None  # which ROS 2 is in use
    ros_misfit: str | None  # that it is for another Python
    ros_conflict: str | None  # what speaks for another one
    ros_remedy: str  # how to get one for this Python
    has_wheels: bool  # whether it is that of this Python's environment
    import_errors: dict[str, str]  # module -> why it cannot be imported
    prefixes: tuple[Prefix, ...]
    python_prefix: str
    is_bootstrapped: bool  # _ROS_WHEELS_BOOTSTRAP_COMPLETE is set
    library_path: tuple[str, ...]  # the entries of LD_LIBRARY_PATH
    version: str
    folder: str  # of the launcher that runs
    installed_version: str | None
    domain_id: str | None  # ROS_DOMAIN_ID
    log_folder: str
    log_obstacle: str | None  # why it cannot be written to
    open_files: int  # the soft limit
    open_files_hard: int
    workspace: WorkspaceFacts | None = None
    network: NetworkFacts | None = None
    settings: SettingsFacts | None = None
    kept_runs: int = 0  # beyond the last ones, in the log folder
    kept_bytes: int = 0
    uncached: Uncached | None = None  # packages whose byte code is lost
