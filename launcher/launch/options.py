"""Options about a run: how its processes are restarted, stopped and limited, and when it ends."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence

from launcher.base.command_line import (
    Option,
    Parsed,
    count,
    option,
    positive_seconds,
    seconds,
)
from launcher.base.errors import UsageError
from launcher.base.model.options import RunOptions
from launcher.base.model.record import replace
from launcher.base.model.spec import UNLIMITED

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def _later(parse: str, **more: Any) -> Callable[[str], Any]:
    """A parser of `process_options`, which is imported only when one of its options is given."""

    def read(word: str) -> Any:
        from launcher.launch import process_options

        return getattr(process_options, parse)(word, **more)

    return read


def _of_recording(parse: str) -> Callable[[str], Any]:
    """The same of `recording`."""

    def read(word: str) -> Any:
        from launcher.launch import recording

        return getattr(recording, parse)(word)

    return read


def _tls(word: str) -> tuple[str, str]:
    from launcher.web.option import parse_tls

    return parse_tls(word)


def _unlimited(name: str) -> int:
    return UNLIMITED  # other hosts may grant more than this machine


def _format(word: str) -> str:
    from launcher.output import line_format

    return line_format.check(word)


def _discovery(word: str) -> str:
    if word not in DISCOVERY_MODES:
        raise ValueError(f"'{word}' is not one of {', '.join(DISCOVERY_MODES)}")
    return word


def settings_in(path: str) -> list[tuple[str, Any]]:
    """(field of RunOptions, value) for each setting in a supervision file; LauncherError."""
    from launcher.launch.supervise.file import read

    return read(path)


DISCOVERY_MODES = ("multicast", "peers", "server")
LOG_LEVEL = option(
    "--log-level NAME[:LOGGER]=LEVEL,...",
    "log level of ROS processes, or of one logger in them: debug, info, warn, error or fatal; as "
    "in robot_1=debug,*=warn",
    _later("parse_log_levels"),
    name="settings",
)
COMPOSE = option(
    "--compose NAME",
    "run the Python nodes that match in one process, which needs less memory; NAME may be a "
    "pattern",
    default=(),
    repeat="all",
)
SKIP_HOST = option(
    "--skip-host NAME",
    "do without a host of the hosts file: what would run there is not started; NAME may be a "
    "pattern",
    name="skip_hosts",
    default=(),
    repeat="all",
)
PREFIX = option(
    "--prefix NAME=WORDS",
    "put words in front of the command of processes, as in 'robot_1=gdb -ex run --args python3' or "
    "'*=nice -n 5'; NAME may be a pattern (in `export` this option is about names of units)",
    _later("parse_prefix"),
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
# The names are fields of RunOptions; `settings` sets several of them.
RECORDING = (
    option(
        "--record[=all]",
        "keep the last messages of all topics in memory, and write them with logs and events when "
        "a process dies, and at `snapshot`; all: write every message into the folder of the run",
        _of_recording("parse_mode"),
        repeat="once",
    ),
    option(
        "--record-keep 60s,256M",
        "how long --record keeps messages, and how much memory they may take",
        _of_recording("parse_keep"),
        repeat="once",
    ),
    option(
        "--record-topics REGEX",
        "record only topics whose names it matches",
        _of_recording("parse_topics"),
    ),
)


def page_options(prefix: str) -> tuple[Option, ...]:
    """Options about the page in the browser, such as `--web-port` for the prefix `web-`."""
    return (
        option(
            f"--{prefix}port N",
            "port of the page (default: 8770, or any if that is taken; 0: any)",
            lambda word: count(word, 0, 65535),
            repeat="once",
        ),
        option(
            f"--{prefix}host ADDRESS",
            "address to listen on (default: 127.0.0.1); others can be reached from other machines",
            repeat="once",
        ),
        option(
            f"--{prefix}tls CERT,KEY",
            "files in PEM: encrypt the page, for an address that others can reach",
            _tls,
            repeat="once",
        ),
        option(
            f"--{prefix}token FILE",
            "use the token in this file in place of a new one",
            os.path.abspath,
            repeat="once",
        ),
        option(f"--{prefix}read-only", "the page only shows, and changes nothing"),
    )


RUN_OPTIONS = (
    option(
        "--restart NAME=MODE[,max=N][,window=S][,delay=S][,backoff=A..B][,quiet=S]",
        "restart processes: never, on-failure or always; NAME may be a pattern",
        _later("parse_restart"),
    ),
    option(
        "--stop NAME=SIGNAL:S,...",
        "stop processes by these signals, with the seconds to wait after each, as in int:2,term:1; "
        "SIGKILL comes last",
        _later("parse_stop"),
    ),
    option("--nice NAME=N", "niceness", _later("parse_nice"), name="limits"),
    option(
        "--cpus NAME=0-1",
        "processors to run on: numbers and ranges, separated by commas",
        _later("parse_cpus", is_here=False),
        name="limits",
    ),
    option(
        "--limit NAME:nofile=256,as=1G,core=0",
        "resource limits, with the names of `ulimit`",
        _later("parse_limit", most_granted=_unlimited),
        name="limits",
    ),
    PREFIX,
    LOG_LEVEL,
    COMPOSE,
    option("--hosts FILE", "run processes on other hosts, as this file says", repeat="once"),
    SKIP_HOST,
    option(
        "--discovery MODE",
        "how the nodes of several hosts find each other: multicast, peers or server",
        _discovery,
        repeat="once",
    ),
    option("--stagger S", "start processes at least S seconds apart", seconds, name="stagger_s"),
    option(
        "--max-starting N",
        "let at most N processes start at the same time",
        lambda word: count(word, 1),
    ),
    option("--required NAME", "end the run when this process ends"),
    option("--exit-when-any-dies", "end the run when a process fails and is not restarted"),
    option("--timeout S", "end the run after S seconds", positive_seconds, name="timeout_s"),
    option(
        "--budget NAME:cpu=80%,memory=200M,threads=N,fds=N,for=S,action=warn|restart|stop-run",
        "limit what a process may use, checked once a second",
        name="budgets",
    ),
    SUPERVISE,
    NO_SUPERVISE,
    option(
        "--warm",
        "start all Python programs warm, from a process that has imported what they need; without "
        "--warm and --cold, Python nodes where that is faster",
        value=True,
    ),
    option("--cold", "start no process warm", name="warm", value=False),
    option(
        "--watch",
        "restart processes when their source or parameter files change, and reload the launch file "
        "when that does",
    ),
    option(
        "--ros",
        "start a node /launcher that publishes /diagnostics and offers services to start, "
        "stop and restart processes, for rqt and Foxglove",
    ),
    *RECORDING,
    option("--web", "serve a page in the browser that shows and controls this run (docs/web.md)"),
    *page_options("web-"),
    option(
        "--responsive",
        "warn of nodes that do not answer any more, with their stacks (30 MB; `top` does it, too)",
    ),
    option(
        "--format FORMAT",
        "lines on the screen: default, compact, or a template with {message}, {severity}, {name}, "
        "{time}, {clock}, {process} and more",
        _format,
    ),
    option(
        "--no-parameter-check",
        "do not warn of parameters that were set and that their nodes do not declare",
        name="check_parameters",
        value=False,
    ),
    option("--no-log-files", "write no log files", name="log_files", value=False),
    option("--no-console", "disable the prompt and the status bar", name="console", value=False),
    option(
        "--no-control",
        "open no socket for other shells; implies --no-console",
        name="control",
        value=False,
    ),
)


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
    if options.watch:
        from launcher.packages.extras import require

        require("watch", "watchfiles", "watching files")
    if options.limits and options.hosts is None:
        _refuse_what_is_not_here(parsed)
    refuse_conflicts(options, options.hosts)
    if options.ros and not options.control:
        raise UsageError("--ros needs the control socket and excludes --no-control")
    if (options.record, options.record_keep, options.record_topics) != (None, None, None):
        from launcher.launch import recording

        recording.check(options)
    if _is_about_page(options):
        from launcher.web import option as page

        page.check(options)
    return options


def _is_about_page(options: RunOptions) -> bool:
    names = ("web", "web_port", "web_host", "web_tls", "web_token", "web_read_only")
    return any(getattr(options, name) != getattr(RunOptions, name) for name in names)


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
    if options.file_names or not options.settings_beside:
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
    parsers = {"--cpus": _later("parse_cpus"), "--limit": _later("parse_limit")}
    for one, words, _ in parsed.given:
        if one in RUN_OPTIONS and one is not None:
            for flag in parsers.keys() & set(one.flags):
                parsers[flag](_value_of(words))
