"""`launch TARGET [name:=value ...]`: run a launch file until its processes have ended."""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
from collections.abc import Callable, Sequence

from launcher.base import text_file
from launcher.base.command_line import Command
from launcher.base.errors import OF_SMOKE, ExitCode, UsageError, exit_code_table
from launcher.base.model.run_options import RunOptions
from launcher.base.option import option
from launcher.base.verb_table import ENABLE, VERBS
from launcher.launch.launch_core import LaunchCore, launched, supervising
from launcher.launch.launch_options import (
    RUN_GROUPS,
    SettingsSource,
    run_options,
    with_settings_beside,
)
from launcher.launch.target import (
    ABOUT_TARGET,
    READING_OPTIONS,
    SYNOPSIS,
    TARGET,
    LaunchRequest,
    parse_words,
)
from launcher.launch.time_limit import limited
from launcher.run.part import HOSTS, OUTPUT
from launcher.run.parts import prepared_hosts, private_domain, with_expectations_beside

TYPE_CHECKING = False
if TYPE_CHECKING:
    from contextlib import AbstractContextManager
    from typing import Protocol

    from launcher.base.model.spec import ProcessSpec
    from launcher.language.interpreter import Interpreter
    from launcher.run.core_driver import Core

    class FleetPlacement(Protocol):
        """Which processes run on other hosts: the host, or None."""

        @property
        def host_of(self) -> Callable[[ProcessSpec], object]: ...

    class PreparedHosts(Protocol):
        """What is known of other hosts and of discovery before the evaluation."""

        # Processes of the launcher's own, which start first.
        @property
        def services(self) -> Sequence[ProcessSpec]: ...

        # None if all processes run here; LauncherError.
        def fleet(self, core: LaunchCore, request: LaunchRequest) -> FleetPlacement | None: ...


def _log_name(text: str) -> str:
    """The name without `.log`."""
    name = text.removesuffix(".log")
    if not name or "/" in name:
        raise ValueError(f"'{text}' is not the name of a file; its folder is that of the run")
    return name


FEW_NODES = 20  # find each other in any case

_OWN = {
    OUTPUT: (
        option(
            "-a, --show-all-subprocesses-output",
            "send the output of every process to the screen and to the log",
            name="show_all",
        ),
        option(
            "-f, --log-file-name NAME",
            "name of the log file with all lines, and of the launcher in it (default: launch)",
            _log_name,
            "launch",
            name="log_name",
        ),
    ),
    HOSTS: (
        option(
            "--enable",
            "install the processes of other hosts there as units of systemd that start at boot, "
            "and start them; nothing is started here",
        ),
        option("--disable", "stop and remove what --enable has installed"),
    ),
}
_ELSEWHERE = (
    (("--dry-run", "--check"), "`PROGRAM plan TARGET` shows what would be started"),
    (("--json",), "`PROGRAM plan TARGET --json` prints what would be started"),
    (
        ("--verbose", "-v", "-vv"),
        "--log-level '*=debug' makes nodes log more; --debug shows the traceback of an error",
    ),
    (
        ("--quiet", "--silent", "-q"),
        "--log-level '*=warn' makes nodes log less; `level WARN`, at the prompt or as "
        "`PROGRAM level WARN`, shows less",
    ),
    (
        ("--background", "--detach", "--daemon"),
        "`PROGRAM TARGET --no-console &` in a shell; `PROGRAM quit` ends it",
    ),
    (("--domain", "--domain-id"), "ROS_DOMAIN_ID=N in front of the command"),
    (("--log-dir", "--log-path"), "ROS_LOG_DIR=DIR in front of the command"),
    (("--no-logs",), "did you mean '--no-log-files'?"),
    (("--hosts-file",), "did you mean '--hosts'?"),
    (("--respawn",), "did you mean --restart NAME=always?"),
    (("--gdb",), "did you mean --prefix 'NAME=gdb -ex run --args'?"),
    (("--ros-args",), "it is for one node: PROGRAM run PACKAGE EXECUTABLE --ros-args ..."),
)
COMMAND = Command(
    "launch",
    VERBS["launch"],
    arguments=(TARGET,),
    synopsis=SYNOPSIS,
    about=f"""\
{ABOUT_TARGET} The word `launch` may be left out.

Ctrl-C stops all processes in order: SIGINT, after 5 s SIGTERM, after 5 s more SIGKILL; press it
again to skip a wait.""",
    options=(
        option(
            "-s, --show-args, --show-arguments",
            "list the arguments of the launch file, as `args` does",
            name="show_args",
        ),
        option(
            "-p, --print, --print-description",
            "show what would be started, as `plan` does",
            name="print_plan",
        ),
        *READING_OPTIONS,
    ),
    exclusive=(("enable", "disable"), ("enable", "private"), ("warm",)),
    elsewhere=_ELSEWHERE,
    groups=tuple((title, (*_OWN.get(title, ()), *options)) for title, options in RUN_GROUPS),
    epilog="\n".join(exit_code_table(code for code in ExitCode if code not in OF_SMOKE)),
)


def main(words: Sequence[str]) -> int:
    """Run the launch file that `words` name; the exit code."""
    parsed = parse_words(COMMAND, words)
    options = run_options(parsed)
    request = LaunchRequest.of(parsed)
    if parsed.show_args:
        from launcher.launch.verbs import args

        return args.show(request)
    options = with_settings_beside(options, request.path)
    source = SettingsSource(parsed, request.path)
    if parsed.show_all:
        # Launch files hand the environment on to other launchers, as with ROS 2.
        os.environ["OVERRIDE_LAUNCH_PROCESS_OUTPUT"] = "both"
    if parsed.print_plan:
        from launcher.launch.verbs import plan

        return plan.show(
            request,
            options=options,
        )
    if parsed.enable or parsed.disable:
        units = importlib.import_module(ENABLE)
        code: int = (units.enable if parsed.enable else units.disable)(request, options)
        return code
    if options.watchful:
        options = with_expectations_beside(options, request.path)
    if not options.private:
        return launch(request, options, source)
    with private_domain(options) as options_with_domain:
        return launch(request, options_with_domain, source)


def launch(request: LaunchRequest, options: RunOptions, source: SettingsSource) -> int:
    """Evaluate the launch file, then run what it describes; a script of a LaunchService runs."""
    from launcher.output.logs.run_directory import provide_log_root

    provide_log_root(os.environ)
    judge = _judge()
    if _is_script(request.path):
        if judge is not None:
            os.close(judge)  # what a script will start is not known
        if options.hosts is not None or options.discovery is not None:
            option = "--hosts" if options.hosts is not None else "--discovery"
            hint = "a launch file with generate_launch_description() can run on several hosts"
            raise UsageError(f"{option} does not apply to a script with a LaunchService", hint=hint)
        if options.compose:
            hint = "a launch file with generate_launch_description() can have composed nodes"
            raise UsageError("--compose does not apply to a script with a LaunchService", hint=hint)
        from launcher.launch.launch_service_run import run_script

        return run_script(request, options)
    return _launch(request, options, source, judge)


def _is_script(path: str) -> bool:
    """Whether a Python file describes nothing, but runs a LaunchService itself."""
    if not path.endswith(".py"):
        return False
    try:
        text = text_file.read_bytes(path)
    except OSError:
        return False  # loading it reports the error
    return b"LaunchService" in text and b"generate_launch_description" not in text


def _launch(
    request: LaunchRequest, options: RunOptions, source: SettingsSource, judge: int | None
) -> int:
    from launcher.language import frontends
    from launcher.language.compat import vocabulary
    from launcher.language.interpreter import Interpreter
    from launcher.output.logs.run_directory import new_run_path

    hosts = _hosts(options)
    run_path = new_run_path(os.environ) if options.log_files else None
    words = [request.path, *(f"{name}:={value}" for name, value in request.arguments)]
    with vocabulary(words) as session:
        # Launch files ask where the logs of their run are.
        session.log_dir = run_path
        session.is_debug, session.log_name = request.debug, request.log_name
        _read_log_formats()
        with _noting_files(options), limited(request.time_limit, request.path):
            description = frontends.load(request.path)
        interpreter = Interpreter(
            description,
            path=request.path,
            arguments=request.arguments,
            noninteractive=request.noninteractive or not sys.stdin.isatty(),
        )
        if hosts is not None or options.start_rules:
            interpreter.note_scopes()
        services = () if hosts is None else hosts.services
        core = LaunchCore(interpreter, description, request, options.with_prefix, source, services)
        try:
            with _noting_files(options):
                core.evaluate()
            _check(core, interpreter, options)
            fleet = None if hosts is None else hosts.fleet(core, request)
            driven: Core = core
            absorbed: frozenset[str] = frozenset()
            if options.compose:
                from launcher.launch import composing

                driven, absorbed = composing.composed(core, options)
            if session.nodes_made > FEW_NODES and fleet is None:
                from launcher.launch.participant_limits import warn_of_crowd

                warn_of_crowd(core, absorbed)
            if session.nodes_made and fleet is None and "ROS_VERSION" not in os.environ:
                _warn_without_ros(core)
            _warn_of_programs(core, fleet)
            if judge is not None and not _is_accepted(judge, core):
                return ExitCode.USAGE  # it says why
            what = launched(
                request,
                path=run_path,
                session=session,
                hosts=fleet,
                switched_off=core.switched_off,
            )
            with supervising(driven, options, what) as (supervisor, _):
                code = supervisor.run()
        finally:
            core.interpreter.close()
    if core.interpreter.failure is not None:
        print(core.interpreter.failure.render(), file=sys.stderr)
        return ExitCode.PROCESS_FAILED
    if code == ExitCode.PROCESS_FAILED:
        from launcher.packages.unbuilt import repeat_warnings

        repeat_warnings()
    return code


def _noting_files(options: RunOptions) -> AbstractContextManager[None]:
    """Within, what the launch file reads is noted if it is to be watched."""
    if not options.watch:
        return contextlib.nullcontext()
    from launcher.launch.files_read import recording

    return recording()


def _judge() -> int | None:
    """The descriptor of a process that reads what will be started, and may refuse it."""
    word = os.environ.pop("LAUNCHER_FORECAST", None)
    if word is None:
        return None  # nearly always, so that nothing is imported for it
    from launcher.launch import run_forecast

    return run_forecast.take_descriptor(word)


def _is_accepted(judge: int, core: LaunchCore) -> bool:
    from launcher.launch import run_forecast

    return run_forecast.is_accepted(judge, core)


def _hosts(options: RunOptions) -> PreparedHosts | None:
    """What is known of other hosts and of discovery before the evaluation; LauncherError."""
    if options.hosts is None and options.discovery is None:
        return None  # nearly always, so that nothing is imported for it
    found: PreparedHosts = prepared_hosts(options)
    return found


def _read_log_formats() -> None:
    """Apply ROS 2's variables for the formats of the launcher's own lines; UsageError."""
    if not any(os.environ.get(f"OVERRIDE_LAUNCH_{what}_FORMAT") for what in ("SCREEN", "LOG")):
        return
    try:
        from launcher.language.logging import config

        config.reset()
    except ValueError as error:
        raise UsageError(str(error), hint="for example: '[{levelname}] [{name}]: {msg}'") from None


def _warn_of_programs(core: LaunchCore, fleet: FleetPlacement | None) -> None:
    """Before the start, of programs on this machine that cannot be executed."""
    from launcher.base.model.events import StartProcess
    from launcher.posix.spawn import is_plain

    specs = [effect.spec for effect in core.effects if isinstance(effect, StartProcess)]
    if all(map(is_plain, specs)):
        return  # nearly always, so that nothing is imported for it
    from launcher.launch.program_warnings import program_warnings

    here = [spec for spec in specs if fleet is None or fleet.host_of(spec) is None]
    for text in program_warnings(here):
        core.interpreter.host.warn_quirk(text, None)
    core.effects = [*core.interpreter.take_effects(), *core.effects]


def _warn_without_ros(core: LaunchCore) -> None:
    """Of nodes of packages, and of scripts that import rclpy; others may be any program."""
    from launcher.launch.program_warnings import is_of_rclpy

    nodes = [(spec, spec.ros.package) for spec in core.starts if spec.ros is not None]
    if not any(package or is_of_rclpy(spec) for spec, package in nodes):
        return
    from launcher.packages.absent_ros import ros_hint

    print(f"warning: there is no ROS 2 for nodes: {ros_hint()}", file=sys.stderr)


def _check(core: LaunchCore, interpreter: Interpreter, options: RunOptions) -> None:
    """LauncherError for a domain, a required process or an order with which it cannot work."""
    if options.start_rules:
        from launcher.launch import launch_checks

        launch_checks.refuse_circles(options.start_rules, core.effects)
    if options.private:
        from launcher.launch import launch_checks

        launch_checks.refuse_other_domains(options, core.effects)
    domain = interpreter.environment.get("ROS_DOMAIN_ID", "")
    is_usual = not domain or (domain.isdecimal() and len(domain) < 3)
    if is_usual and not options.required:
        return  # nearly always, so that nothing is imported for it
    from launcher.launch import launch_checks

    launch_checks.refuse_domain(domain, core.effects)
    if not interpreter.may_start_more:
        launch_checks.refuse_missing(options.required, core.effects)
