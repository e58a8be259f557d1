"""The specification of a process: command, environment, policies, as plain data."""

from __future__ import annotations

import enum
import signal
from collections.abc import Mapping, Sequence

from launcher.base.model.record import Record


class Sink(enum.Flag):
    """Where a stream of a process goes; see `OutputPolicy.named` for the names in ROS 2."""

    NONE = 0
    SCREEN = enum.auto()
    LOG = enum.auto()
    OWN_LOG = enum.auto()


class OutputPolicy(Record):
    """Sinks of each stream, as ROS 2's `output=` (CONFORMANCE 1.30).

    `combined` is the file that holds both streams in order of arrival, `stdout` and `stderr`
    those of one stream.
    """

    stdout: Sink = Sink.LOG
    stderr: Sink = Sink.LOG | Sink.SCREEN
    combined: Sink = Sink.NONE

    @classmethod
    def named(cls, name: str) -> OutputPolicy:
        """The policy for `screen`, `log`, `both`, `own_log` or `full`; ValueError otherwise."""
        try:
            return _NAMED_POLICIES[name]()
        except KeyError:
            raise ValueError(
                f"{name} is not a valid standard output config i.e. "
                f'"screen", "log", "both", "own_log" or "full"'
            ) from None


def _both(sinks: Sink, combined: Sink = Sink.NONE) -> OutputPolicy:
    return OutputPolicy(stdout=sinks, stderr=sinks, combined=combined)


_NAMED_POLICIES = {
    "screen": lambda: _both(Sink.SCREEN),
    "log": lambda: OutputPolicy(stdout=Sink.LOG, stderr=Sink.LOG | Sink.SCREEN),
    "both": lambda: _both(Sink.SCREEN | Sink.LOG),
    "own_log": lambda: _both(Sink.OWN_LOG, combined=Sink.OWN_LOG),
    "full": lambda: _both(Sink.SCREEN | Sink.LOG | Sink.OWN_LOG, combined=Sink.OWN_LOG),
}


class RestartMode(enum.Enum):
    """When a process that exited is restarted."""

    NEVER = "never"
    ON_FAILURE = "on-failure"
    ALWAYS = "always"


class RestartPolicy(Record):
    """Whether, when and how often a process is started again; all times in seconds.

    ROS 2's `respawn=True, respawn_delay=d, respawn_max_retries=n` is
    `RestartPolicy(mode=ALWAYS, delay_s=d, max_restarts=n)`. `max_restarts` None means without
    limit; with `window_s` it limits those within the last `window_s` seconds. With
    `backoff_max_s` the delay doubles from `delay_s` up to it, and is reset after a run of
    `quiet_s`; `jitter` is the largest random part of a delay, so that a fleet does not restart in
    step.
    """

    mode: RestartMode = RestartMode.NEVER
    delay_s: float = 0.0
    max_restarts: int | None = None
    window_s: float | None = None
    backoff_max_s: float | None = None
    quiet_s: float = 30.0
    jitter: float = 0.0

    def wants_restart(self, *, failed: bool) -> bool:
        """Whether the mode has a restart after such an exit."""
        return self.mode is RestartMode.ALWAYS or (self.mode is RestartMode.ON_FAILURE and failed)

    def allows(self, restarts: int, recent: Sequence[float], now: float) -> bool:
        """Whether one more start is within the budget.

        `restarts` counts those made; `recent` are the times of the last `max_restarts` of them.
        """
        if self.max_restarts is None:
            return True
        if self.window_s is None:
            return restarts < self.max_restarts
        return sum(when > now - self.window_s for when in recent) < self.max_restarts

    def delay_after(self, quick_ends: int, chance: float) -> float:
        """Seconds to wait after `quick_ends` quick exits in a row; `chance` is in [0, 1)."""
        delay_s = self.delay_s
        if self.backoff_max_s is not None:
            delay_s = min(self.delay_s * 2.0 ** min(quick_ends, 60), self.backoff_max_s)
        return delay_s * (1.0 + self.jitter * chance)


AFTER_KILL_S = 5.0  # a process that still exists then is in uninterruptible sleep


class StopPolicy(Record):
    """The signals that stop a process, up to SIGKILL; ROS 2's `sigterm_timeout`, `sigkill_timeout`.

    `sigterm_timeout_s` is the time from SIGINT to SIGTERM, `sigkill_timeout_s` that from SIGTERM
    to SIGKILL, in seconds. `polite` replaces both: (signal, seconds until the next) in order.
    """

    sigterm_timeout_s: float = 5.0
    sigkill_timeout_s: float = 5.0
    polite: tuple[tuple[signal.Signals, float], ...] | None = None

    @property
    def steps(self) -> tuple[tuple[signal.Signals, float], ...]:
        """(signal, seconds until the next step) in order; SIGKILL is always the last."""
        polite = self.polite
        if polite is None:
            polite = (
                (signal.SIGINT, self.sigterm_timeout_s),
                (signal.SIGTERM, self.sigkill_timeout_s),
            )
        return (*polite, (signal.SIGKILL, AFTER_KILL_S))

    @property
    def grace_s(self) -> float:
        """Seconds until SIGKILL."""
        return sum(wait_s for _, wait_s in self.steps[:-1])


class ParameterSource(Record):
    """One element of a node's parameters on its command line, in the plan document's terms.

    Either `file` or `rule` is set: `file` is a path, `rule` is `name:=value`. `generated` is the
    content of `file` where the launcher wrote it, else None.
    """

    file: str | None = None
    rule: str | None = None
    generated: Mapping[str, object] | None = None


class RosIdentity(Record):
    """The ROS node of a process, for users and for the plan document.

    `namespace` is absolute, None where the launch file gives none; `remappings` are
    (from, to) in the order of the command line.
    """

    package: str | None = None
    executable: str | None = None
    node_name: str | None = None
    namespace: str | None = None
    remappings: tuple[tuple[str, str], ...] = ()
    parameters: tuple[ParameterSource, ...] = ()


class Scope(Record):
    """An included launch file around a process, or a group (`line` above 0).

    `path` is the file, of a group that in which it stands; `namespace` what the group pushes.
    """

    path: str
    line: int = 0
    namespace: str | None = None


class ProcessSpec(Record):
    """One process, final: argv, environment, names are plain strings.

    `name` is the label with its running number (`robot_1-2`), unique in a run; `label` is the
    same without it. `output_given` is the launch file's own spelling of `output`, for the plan,
    and so are the two timeouts `..._given`; `chooses_output`: it is not the default of ROS 2.
    `place` is the file and line of the action. `scopes` are what is around it, the outermost first;
    only runs with a hosts file have them. `members` are the processes of the launch file that this
    one is instead of; `is_essential`: the end of this member ends all.
    """

    name: str
    label: str
    argv: tuple[str, ...]
    env: Mapping[str, str]
    cwd: str | None = None
    shell: bool = False
    emulate_tty: bool = False
    output: OutputPolicy = OutputPolicy()
    output_given: str | Mapping[str, object] = "log"
    chooses_output: bool = True
    restart: RestartPolicy = RestartPolicy()
    stop: StopPolicy = StopPolicy()
    limits: Limits | None = None
    ros: RosIdentity | None = None
    sigterm_timeout_given: str = "5"
    sigkill_timeout_given: str = "5"
    place: str = "the launch file"
    scopes: tuple[Scope, ...] = ()
    members: tuple[ProcessSpec, ...] = ()
    is_essential: bool = False

    @property
    def command_line(self) -> str:
        """The words as ROS 2 prints them in `process has died`: joined by a blank, unquoted."""
        if self.members:  # each word of each of them would fill a screen
            return f"{' '.join(self.argv[:3])} ... ({len(self.members)} nodes)"
        return " ".join(self.argv)


UNLIMITED = -1  # as `resource.RLIM_INFINITY`


class Limits(Record):
    """Limits of a process; what is None, or not in `rlimits`, is inherited from the launcher.

    `rlimits` are (name as in `nofile`, soft, hard), each name once.
    """

    nice: int | None = None
    cpus: tuple[int, ...] | None = None
    rlimits: tuple[tuple[str, int, int], ...] = ()

    def over(self, other: Limits) -> Limits:
        """Both limits; this one overrides the other."""
        named = {rlimit[0]: rlimit for rlimit in (*other.rlimits, *self.rlimits)}
        return Limits(
            nice=other.nice if self.nice is None else self.nice,
            cpus=other.cpus if self.cpus is None else self.cpus,
            rlimits=tuple(named.values()),
        )


def replaces(env: Mapping[str, str], before: Mapping[str, str]) -> bool:
    """Whether the launch file gives the whole environment: most of that of before is not in it.

    So it is with `env={}` and ReplaceEnvironmentVariables, unless they copy what was there.
    """
    return sum(name in env for name in before) * 2 < len(before)
