"""What happens in a run, as the entries of its event log say it: a type for each kind of event.

Writers make these, and `event_entries` reads them back; docs/reference/events.md is made from them.
Fields are named in snake case, durations end in `_s`, and what is not known is None. A field with a
default is left out of the entry while it has it. The docstring of a type is a sentence, and a line
for each field.
"""

from __future__ import annotations

from launcher.base.model.events import signal_name
from launcher.base.model.record import Record
from launcher.base.model.run_event import SAMPLES, RunEvent, duration, exit_text, listed

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping

    # How a value is read and shown; `event_entries.FIELD_TYPES` has the same names.
    Count = int
    Names = tuple[str, ...]
    Percent = float
    Pid = int
    ReturnCode = int
    Seconds = float
    SignalNumber = int
    Size = int


# ---- starts and exits


class Waiting(RunEvent):
    """A first start waits for other processes ([supervision](supervision.md)).

    after: the processes, as the supervision file names them
    timeout_s: how long it waits at most
    """

    event, about = "waiting", "process"
    words = "waits for {after}, at most {timeout_s}"
    after: Names
    timeout_s: Seconds


class Released(RunEvent):
    """A start waits for other processes no more.

    waited_s: how long it has waited
    why: `ready`, `timeout`, `requested`, or what follows a timeout: `fail`, `stop-run`
    processes: what it waited for
    """

    event, about = "released", "process"
    waited_s: Seconds
    why: str
    processes: Names

    @property
    def text(self) -> str:
        return f"has waited {duration(self.waited_s)}: {_RELEASED.get(self.why, self.why)}"


class Started(RunEvent):
    """The process runs.

    pid: of the process
    restarts: how often it was restarted before
    ready_when: facts of `ready_when` that it lacks now
    """

    event, about = "started", "process"
    pid: Pid
    restarts: Count
    ready_when: Names = ()

    @property
    def text(self) -> str:
        return f"started, pid {self.pid}" + (f", restart {self.restarts}" if self.restarts else "")


class Ready(RunEvent):
    """All facts of its `ready_when` hold.

    ready_s: how long that took from its start
    """

    event, about = "ready", "process"
    words = "ready after {ready_s}"
    ready_s: Seconds


class Adopted(RunEvent):
    """The run was attached to (`attach`), and found the process on its host.

    pid: of the process
    state: as in `ps`
    restarts: how often it was restarted before
    """

    event, about = "adopted", "process"
    pid: Pid | None
    state: str
    restarts: Count

    @property
    def text(self) -> str:
        return f"was there already: {self.state}" + (f", pid {self.pid}" if self.pid else "")


class NotStarted(RunEvent):
    """The process could not be started.

    reason: why
    """

    event, about = "not started", "process"
    words = "could not be started: {reason}"
    reason: str

    @property
    def is_failure(self) -> bool:
        return True


class Withdrawn(RunEvent):
    """A start that was queued, or waited, was cancelled."""

    event, about = "withdrawn", "process"
    words = "its start was cancelled"


class Ended(RunEvent):
    """The process has ended.

    pid: of the process
    returncode: its exit code, or minus the number of the signal that ended it
    asked: whether it did as a user, the launch file or the end of the run requested: not by a crash
    restart_in_s: when it is started again; null if it is not
    """

    event, about = "ended", "process"
    pid: Pid | None
    returncode: ReturnCode
    asked: bool
    restart_in_s: Seconds | None

    @property
    def text(self) -> str:
        how = exit_text(self.returncode) + ", requested" * self.asked
        again = "" if self.restart_in_s is None else f"; restart in {duration(self.restart_in_s)}"
        return f"ended ({how}){again}"

    @property
    def is_failure(self) -> bool:
        return self.returncode != 0 and not self.asked


class MemberEnded(RunEvent):
    """A node of a composed process has ended ([compose](../guides/many-nodes.md)).

    member: its name
    returncode: its exit code, or minus the number of the signal that ended it
    """

    event, about = "member ended", "process"
    words = "{member} in it ended ({returncode})"
    member: str
    returncode: ReturnCode


# ---- signals and requests


class Signalled(RunEvent):
    """The launcher has sent a signal to the process and its group; not the SIGCONT behind a stop.

    pid: of the process
    signal: its number
    """

    event, about = "signal", "process"
    words = "got {signal}"
    pid: Pid | None
    signal: SignalNumber


class Stuck(RunEvent):
    """The process still exists after SIGKILL.

    pid: of the process
    sleeps: its state in the kernel, and where it waits there; null on another host
    """

    event, about = "stuck", "process"
    pid: Pid | None
    sleeps: str | None

    @property
    def text(self) -> str:
        return "still exists after SIGKILL" + (f" ({self.sleeps})" if self.sleeps else "")


class Asked(RunEvent):
    """A user has requested something: of a process, or of the run (`detach`, `quit`).

    verb: `start`, `stop`, `restart`, `debug`, `kill`, `pause`, `resume`, `detach` or `quit`
    signal: the number of that which `kill` sends
    """

    event, about = "asked", "either"
    verb: str
    signal: SignalNumber | None = None

    @property
    def text(self) -> str:
        which = "" if self.signal is None else f" with {signal_name(self.signal)}"
        return f"requested: {self.verb}{which}"


# ---- watching processes


class NotResponding(RunEvent):
    """Nodes of the process do not answer
    ([debugging.md](debugging.md#nodes-that-do-not-respond)).

    silent_s: how long they have not
    """

    event, about = "not responding", "process"
    words = "has not responded for {silent_s}"
    silent_s: Seconds


class Responds(RunEvent):
    """They answer again.

    silent_s: how long they had not
    """

    event, about = "responds", "process"
    words = "responds again, after {silent_s}"
    silent_s: Seconds


class OverBudget(RunEvent):
    """The process has exceeded a budget for too long.

    action: what follows: `warn`, `restart` or `stop-run`
    """

    event, about = "over budget", "process"
    words = "uses more than its budget: {action}"
    action: str


class Sample(Record):
    """Resource usage of one process with its descendants.

    pid: of the process itself
    cpu_percent: of one core since the last sample, so four busy threads are 400; null: the first
    rss_bytes: shared pages count once per process
    uss_bytes: what would be free if all exited, up to 10 s old; null until it is known of all that
        were in the first sample (later ones count after a second)
    threads: of all
    fds: open file descriptors of all
    processes: how many there are
    """

    pid: Pid
    cpu_percent: Percent | None
    rss_bytes: Size
    uss_bytes: Size | None
    threads: Count
    fds: Count
    processes: Count


class Resources(RunEvent):
    """A sample of all processes, once a second, with more than 100 processes less often.

    processes: the sample of each process by its name
    """

    event = SAMPLES
    processes: Mapping[str, Sample]

    @property
    def text(self) -> str:
        return f"resources of {listed(tuple(self.processes))}"


# ---- the run


class FilesChanged(RunEvent):
    """Files that processes have loaded have changed ([watch](../guides/editing.md)).

    files: their paths
    processes: those that are restarted
    """

    event = "files changed"
    words = "files changed: {files}; restarts: {processes}"
    files: Names
    processes: Names


class Reloaded(RunEvent):
    """The launch file was evaluated again ([reload](../guides/editing.md#reload)).

    new: processes that are started
    gone: processes that are stopped
    changed: processes that are not as before
    same: all others
    """

    event = "reloaded"
    new: Names
    gone: Names
    changed: Names
    same: Names

    @property
    def text(self) -> str:
        changes = {"new": self.new, "gone": self.gone, "changed": self.changed}
        texts = [f"; {what}: {listed(names)}" for what, names in changes.items() if names]
        return f"launch file reloaded{''.join(texts)}"


class SnapshotWritten(RunEvent):
    """The flight recorder has written a snapshot ([flight recorder](bags.md#the-flight-recorder)).

    path: its folder
    reason: why
    """

    event = "snapshot"
    words = "snapshot {path} ({reason})"
    path: str
    reason: str


class LinkChanged(RunEvent):
    """The link to another host has changed ([hosts](hosts.md#a-lost-link)).

    host: its name
    state: `connecting`, `ready`, `unreachable`, or `gone`: nothing will come any more
    reason: why, or empty
    """

    event = "link"
    host: str
    state: str
    reason: str

    @property
    def text(self) -> str:
        return f"host {self.host}: {self.state}" + (f" ({self.reason})" if self.reason else "")


class Stopping(RunEvent):
    """The run begins to stop its processes.

    reason: why
    """

    event = "stopping"
    words = "the run stops: {reason}"
    reason: str


class Finished(RunEvent):
    """The last entry of a run.

    exit_code: of the launcher
    deaths: how often a process has died, also one that was restarted
    """

    event = "finished"
    words = "the run has ended with exit code {exit_code}"
    exit_code: Count
    deaths: Count = 0


_RELEASED = {
    "ready": "what it waited for is ready",
    "timeout": "it has waited long enough",
    "requested": "it was requested",
    "fail": "what it waited for has not come: it is not started",
    "stop-run": "what it waited for has not come: the run ends",
}


def known(pid: int) -> int | None:
    """The pid; None for one that is not known, which the engine has as -1."""
    return pid if pid > 0 else None
