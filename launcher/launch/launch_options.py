"""Options about a run: how its processes are restarted, stopped and limited, and when it ends."""

from __future__ import annotations

import os
from collections.abc import Sequence

from launcher.base.command_line import Parsed
from launcher.base.errors import UsageError
from launcher.base.model.record import replace
from launcher.base.model.run_options import RunOptions
from launcher.base.model.spec import UNLIMITED
from launcher.base.option import Option, lazy, option
from launcher.run.part import DEVELOPMENT, OPTION_GROUPS, OUTPUT, RESOURCES, RESTARTS
from launcher.run.parts import check_options, part_options

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


# Imported only when one of these options is given.
_PARSERS = "launcher.launch.process_options"


def _unlimited(name: str) -> int:
    return UNLIMITED  # other hosts may grant more than this machine


# (field of RunOptions, value) for each setting in a supervision file; LauncherError.
settings_in = lazy("launcher.launch.supervise.supervise_reader:read")

LOG_LEVEL = option(
    "--log-level NAME[:LOGGER]=LEVEL,...",
    "log level of ROS processes, or of one logger in them: debug, info, warn, error or fatal; as "
    "in robot_1=debug,*=warn",
    lazy(f"{_PARSERS}:parse_log_levels"),
    name="settings",
)
PREFIX = option(
    "--prefix NAME=WORDS",
    "put words in front of the command of processes, as in 'robot_1=gdb -ex run --args python3' or "
    "'*=nice -n 5'; NAME may be a pattern (in `export` this option is about names of units)",
    lazy(f"{_PARSERS}:parse_prefix"),
    default=(),
    repeat="all",
)
SUPERVISE = option(
    "--supervise, --budgets FILE",
    "what is to be known of processes, as in NAME: {after: OTHER, memory: 200M}: when they are "
    "ready, which wait for others, how they are restarted, stopped and limited (default: "
    "NAME.supervise.yaml beside the launch file)",
    settings_in,
    name="settings",
)
NO_SUPERVISE = option(
    "--no-supervise",
    "do not use the supervision file beside the launch file",
    name="settings_beside",
    value=False,
)
# Those that belong to no part, in the groups of help.
_OWN = {
    RESTARTS: (
        option(
            "--restart NAME=MODE[,max=N][,window=S][,delay=S][,backoff=A..B][,quiet=S]",
            "restart processes: never, on-failure or always; NAME may be a pattern",
            lazy(f"{_PARSERS}:parse_restart"),
        ),
        option(
            "--stop NAME=SIGNAL:S,...",
            "stop processes by these signals, with the seconds to wait after each, as in "
            "int:2,term:1; SIGKILL comes last",
            lazy(f"{_PARSERS}:parse_stop"),
        ),
        option("--required NAME", "end the run when this process ends"),
        option("--exit-when-any-dies", "end the run when a process fails and is not restarted"),
        SUPERVISE,
        NO_SUPERVISE,
    ),
    OUTPUT: (
        option(
            "--format FORMAT",
            "lines on the screen: default, compact, or a template with {message}, {severity}, "
            "{name}, {time}, {clock}, {process} and more",
            lazy("launcher.output.line_format:check"),
        ),
        LOG_LEVEL,
        option("--no-log-files", "write no log files", name="log_files", value=False),
    ),
    RESOURCES: (
        option("--nice NAME=N", "niceness", lazy(f"{_PARSERS}:parse_nice"), name="limits"),
        option(
            "--cpus NAME=0-1",
            "processors to run on: numbers and ranges, separated by commas",
            lazy(f"{_PARSERS}:parse_cpus", is_here=False),
            name="limits",
        ),
        option(
            "--limit NAME:nofile=256,as=1G,core=0",
            "resource limits, with the names of `ulimit`",
            lazy(f"{_PARSERS}:parse_limit", most_granted=_unlimited),
            name="limits",
        ),
    ),
    DEVELOPMENT: (PREFIX,),
}
# The names are fields of RunOptions; `settings` sets several of them.
RUN_GROUPS = tuple((title, (*_OWN.get(title, ()), *part_options(title))) for title in OPTION_GROUPS)
RUN_OPTIONS = tuple(option for _, options in RUN_GROUPS for option in options)


def given_options(parsed: Parsed) -> RunOptions:
    """The options about the run, each by itself."""
    return _options_of(parsed.given)


def _options_of(given: Sequence[tuple[Option | None, list[str], Any]]) -> RunOptions:
    fields: dict[str, Any] = {}
    for one, _, value in given:
        if one in RUN_OPTIONS:
            for name, item in value if one.name == "settings" else [(one.name, value)]:
                several = isinstance(getattr(RunOptions, name), tuple)
                fields[name] = (*fields.get(name, ()), item) if several else item
    return RunOptions(**fields)


def run_options(parsed: Parsed) -> RunOptions:
    """The options about the run; UsageError."""
    options = given_options(parsed)
    if options.limits and options.hosts is None:
        _refuse_what_is_not_here(parsed)
    refuse_conflicts(options, options.hosts)
    check_options(options)
    return options


def refuse_conflicts(options: RunOptions, hosts: str | None) -> None:
    """UsageError for options that neither a run nor its plan can have."""
    if options.prefix and hosts is None:
        from launcher.launch.process_options import refuse_absent_programs

        refuse_absent_programs(options.prefix)
    if options.skip_hosts and hosts is None:
        raise UsageError("--skip-host needs --hosts FILE")
    if options.compose and hosts is not None:
        raise UsageError("--compose and --hosts exclude each other")


def with_settings_beside(options: RunOptions, launch_file: str) -> RunOptions:
    """With the supervision file beside the launch file, unless one is given; LauncherError.

    Options of the command line override it.
    """
    is_given = options.file_names or options.fault_actions
    if is_given or not options.settings_beside:
        return options
    path = supervision_file(launch_file)
    if not os.path.isfile(path):
        return options
    fields: dict[str, Any] = {}
    for name, value in settings_in(path):
        fields[name] = (*fields.get(name, ()), value)
    more = {name: (*values, *getattr(options, name)) for name, values in fields.items()}
    return replace(options, **more)


def supervision_file(launch_file: str) -> str:
    """`system.supervise.yaml` for `system.launch.py`, in the same folder."""
    folder, name = os.path.split(launch_file)
    ends = (".launch.", "_launch.", "-launch.", ".")
    stem = next((name.partition(end)[0] for end in ends if end in name), name)
    return os.path.join(folder, f"{stem}.supervise.yaml")


class SettingsSource:
    """The options of a run, whose supervision files may be read again."""

    def __init__(self, parsed: Parsed, launch_file: str) -> None:
        self._given = parsed.given
        self._launch_file = launch_file

    @property
    def paths(self) -> list[str]:
        """The files that are given, or that beside the launch file, which need not exist."""
        paths = [_value_of(words) for one, words, _ in self._given if one is SUPERVISE]
        is_used = paths or not _options_of(self._given).settings_beside
        return paths if is_used else [supervision_file(self._launch_file)]

    def read(self) -> RunOptions:
        """LauncherError if a file has mistakes."""
        given = [
            (one, words, settings_in(_value_of(words)) if one is SUPERVISE else value)
            for one, words, value in self._given
        ]
        return with_settings_beside(_options_of(given), self._launch_file)


def _value_of(words: Sequence[str]) -> str:
    """Of `--option=VALUE`, or `--option VALUE`."""
    return words[0].partition("=")[2] if len(words) == 1 else words[1]


def _refuse_what_is_not_here(parsed: Parsed) -> None:
    """UsageError for processors that this machine lacks, and limits that it does not grant."""
    parsers = {
        "--cpus": lazy(f"{_PARSERS}:parse_cpus"),
        "--limit": lazy(f"{_PARSERS}:parse_limit"),
    }
    for one, words, _ in parsed.given:
        if one in RUN_OPTIONS and one is not None:
            for flag in parsers.keys() & set(one.flags):
                parsers[flag](_value_of(words))
