"""The options of a run, which override or complete its launch file."""

from __future__ import annotations

import fnmatch
import os
from collections.abc import Iterable, Sequence

from launcher.base.model.record import Record, replace
from launcher.base.model.spec import ProcessSpec, RestartPolicy, StopPolicy

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.base.model.spec import Limits

_LOG_LEVEL = "--log-level"  # of a ROS process
_SUFFIXES = (".py", ".sh")  # of a program, which may be left out


class RunOptions(Record):
    """`restart` and `stop` are (pattern, policy) pairs, of which the last that matches counts.

    `limits` are such pairs, too, which are merged; later ones override. `prefix` are (pattern,
    words in front of the command), of which the last that matches counts. `log_levels` are
    (pattern, (logger or nothing, level)). `stagger_s` is the least time between two starts,
    `max_starting` how many processes may be starting at the same time (None: any number). The run
    ends when a process that matches `required` exits, after `timeout_s`, after
    `stop_after_quiet_s` without a line, or with `exit_when_any_dies` after the first failure
    without a restart. `budgets` are limits on resources (see `budget_parser`), as are
    `file_budgets`, of supervision files; `start_rules` are the StartRules of these (see
    `supervision`), `file_names` the names of processes in them, each
    with its place, and `settings_beside` says whether to look for one beside the launch file.
    `format` is the form of lines on the screen (see `output.line_format`). `control`: open
    the control socket; `ros`: publish the state of the run in ROS. `hosts` is the path of a hosts
    file, `discovery` how nodes find each other, `skip_hosts` are patterns of hosts that are not
    used. `record`: `flight` or `all`, with the bounds `record_keep` (seconds, bytes) and the
    regular expression `record_topics`. `web`: serve the page in the browser, with the `web_`
    settings (docs/guides/browser.md). `warm`: start Python programs warm (docs/inside/warm.md), or
    none; None: nodes, where that is faster. What matches one of `compose` runs in one process.
    `expect`: a file of expectations that hold while the run lives, with `watchful` that beside the
    launch file; `fault_actions` are the FaultActions of supervision files.
    `private`: in a ROS domain that no other run has, `domain_id`. `introduce`: help new nodes to
    discover those that run already. `chaos_plan`: the file with a plan of injected faults.
    """

    restart: tuple[tuple[str, RestartPolicy], ...] = ()
    stop: tuple[tuple[str, StopPolicy], ...] = ()
    limits: tuple[tuple[str, Limits], ...] = ()
    prefix: tuple[tuple[str, tuple[str, ...]], ...] = ()
    log_levels: tuple[tuple[str, tuple[str, str]], ...] = ()
    stagger_s: float = 0.0
    max_starting: int | None = None
    required: tuple[str, ...] = ()
    compose: tuple[str, ...] = ()
    exit_when_any_dies: bool = False
    timeout_s: float | None = None
    stop_after_quiet_s: float | None = None
    format: str = "default"
    log_files: bool = True
    control: bool = True
    console: bool = True
    ros: bool = False
    record: str | None = None
    record_keep: tuple[float, int] | None = None
    record_topics: str | None = None
    expect: str | None = None
    watchful: bool = False
    fault_actions: tuple[Any, ...] = ()
    web: bool = False
    web_port: int | None = None
    web_host: str | None = None
    web_tls: tuple[str, str] | None = None
    web_token: str | None = None
    web_read_only: bool = False
    watch: bool = False
    check_parameters: bool = True
    responsive: bool = False
    budgets: tuple[str, ...] = ()
    file_budgets: tuple[Any, ...] = ()
    start_rules: tuple[Any, ...] = ()
    file_names: tuple[tuple[str, str], ...] = ()
    settings_beside: bool = True
    hosts: str | None = None
    discovery: str | None = None
    skip_hosts: tuple[str, ...] = ()
    private: bool = False
    domain_id: int | None = None
    check_domain: bool = True
    introduce: bool = True
    warm: bool | None = None
    chaos_plan: str | None = None

    @property
    def has_budgets(self) -> bool:
        return bool(self.budgets or self.file_budgets)

    @property
    def name_processes(self) -> bool:
        by_words = self.restart or self.stop or self.limits or self.prefix or self.required
        return bool(by_words or self.budgets or self.file_names or self.log_levels or self.compose)

    def adapt(self, spec: ProcessSpec) -> ProcessSpec:
        for pattern, policy in self.restart:
            if matches(pattern, spec):
                spec = replace(spec, restart=policy)
        for pattern, stop in self.stop:
            if matches(pattern, spec):
                spec = replace(spec, stop=stop)
        for pattern, limits in self.limits:
            if matches(pattern, spec):
                spec = replace(spec, limits=limits.over(spec.limits) if spec.limits else limits)
        if self.log_levels and spec.ros is not None:
            given = [one for one in self.log_levels if matches(one[0], spec)]
            spec = _with_levels(spec, given, names_of(spec))
        return self.with_prefix(spec) if self.prefix else spec

    def with_prefix(self, spec: ProcessSpec) -> ProcessSpec:
        found = [words for pattern, words in self.prefix if matches(pattern, spec)]
        if not found:
            return spec
        words = found[-1]
        if spec.shell:  # its words become a text, which the shell splits again
            import shlex

            words = tuple(map(shlex.quote, words))
        return replace(spec, argv=(*words, *spec.argv))

    def is_required(self, spec: ProcessSpec) -> bool:
        return any(matches(pattern, spec) for pattern in self.required)


def matches(pattern: str, spec: ProcessSpec) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for name in names_of(spec))


def names_of(spec: ProcessSpec) -> list[str]:
    """Names of this process: its name, its label, and the name of its node; of its members, too."""
    names = [spec.name, spec.label, *program_of(spec.label)]
    names += [name for one in spec.members for name in names_of(one)]
    if spec.ros is not None and spec.ros.node_name is not None:
        names += [spec.ros.node_name, spec.ros.node_name.rpartition("/")[2]]
    return names


def program_of(label: str) -> tuple[str, ...]:
    """`talker` for a process of talker.py: it may be named without the suffix; () without one."""
    stem, suffix = os.path.splitext(label)
    return (stem,) if suffix in _SUFFIXES else ()


def _with_levels(
    spec: ProcessSpec, given: Iterable[tuple[str, tuple[str, str]]], names: Iterable[str]
) -> ProcessSpec:
    """The process with what (pattern, (logger or nothing, level)) set, all of which match it.

    A level of the process replaces all that its launch file sets, that of a logger those of this
    logger. One of its names counts before a pattern, and that before `*`; else the last.
    """
    ranked = sorted(given, key=lambda one: 2 if one[0] in names else int(one[0] != "*"))
    levels = dict(setting for _, setting in ranked)
    if not levels:
        return spec
    values = [f"{logger}:={level}" if logger else level for logger, level in levels.items()]
    words = [word for value in values for word in (_LOG_LEVEL, value)]
    # Behind `--ros-args` once more, since a `--` may have ended the words of ROS.
    return replace(spec, argv=(*_without(spec.argv, levels), "--ros-args", *words))


def _without(argv: Sequence[str], levels: Iterable[str]) -> list[str]:
    """The words without the levels that are replaced."""
    kept: list[str] = []
    is_ros = is_value = False
    for word in argv:
        if is_value:
            is_value = False
            logger = word.rpartition(":=")[0]
            if "" in levels or logger in levels:
                kept.pop()
                continue
        elif word in ("--ros-args", "--"):
            is_ros = word == "--ros-args"
        else:
            is_value = is_ros and word == _LOG_LEVEL
        kept.append(word)
    return kept
