"""`TARGET [name:=value ...]`: run a launch file until its processes have ended."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from launcher.commands.launch import target as command_line
from launcher.commands.launch.target import LaunchRequest
from launcher.commands.launch.time_limit import TimeLimit, limited
from launcher.errors import (
    ExitCode,
    LauncherError,
    LaunchFileError,
    UsageError,
    exit_code_table,
)
from launcher.model.options import RunOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.commands.launch.helpers import Helpers
    from launcher.interpreter import Interpreter
    from launcher.language.description import LaunchDescription
    from launcher.model.events import Effect, Event

MOST_CHAPTERS = 2000  # of what a run did, for its plan; memory is bounded

SYNOPSIS = "usage: python -m launcher TARGET [name:=value ...] [options]"
_USAGE = f"""{SYNOPSIS}
       python -m launcher PACKAGE FILE [name:=value ...] [options]

TARGET is a launch file or the name of one: `system` for launch/system.launch.py.
Ctrl-C stops everything in order: SIGINT, after 5 s SIGTERM, after 5 s more SIGKILL; pressed
again it does not wait.

instead of launching:
  -s, --show-args      list the arguments (python -m launcher args)
  -p, --print          show what would be started (python -m launcher plan)

options:
  --lenient            accept argument names that nothing declares or reads, as ROS 2 does
  -n, --noninteractive the launch file is told that there is no terminal
  -a, --show-all-subprocesses-output
                       every process's output on the screen and in the log
  --launch-prefix WORDS, --launch-prefix-filter REGEX
                       put words in front of the commands (of those that match)
{{run_help}}
  --evaluation-timeout S
                       how long reading the launch file may take; 0 for any time (default: 60 s,
                       and 20 s of computing)
  -d, --debug          show the traceback of an error"""

# What steers a run takes 15 ms to import. Children are starting then, and some have ended already.
ATTEND_AFTER_S = 0.05

SHOW_ARGS = ("--show-args", "-s", "--show-arguments")
PRINT = ("--print", "-p", "--print-description")
LENIENT = ("--lenient",)
NONINTERACTIVE = ("--noninteractive", "-n")
SHOW_ALL = ("--show-all-subprocesses-output", "-a")
PREFIX = ("--launch-prefix",)
PREFIX_FILTER = ("--launch-prefix-filter",)
PATIENCE = ("--evaluation-timeout",)


def main(words: Sequence[str]) -> int:
    """Run the launch file that `words` name; the exit code."""
    if command_line.wants_help(words):
        print(usage())
        return ExitCode.OK
    options, rest = _take_run_options(words)
    request = command_line.read(
        rest,
        verb="launch",
        usage=SYNOPSIS,
        flags=(SHOW_ARGS, PRINT, LENIENT, NONINTERACTIVE, SHOW_ALL),
        valued=(PREFIX, PREFIX_FILTER, PATIENCE),
    )
    patience = TimeLimit.given(request.options.get(PATIENCE[0]))
    if SHOW_ARGS[0] in request.options:
        from launcher.commands import args

        return args.show(request.path, patience)
    request = _with_prefix(request)
    if SHOW_ALL[0] in request.options:
        # ROS 2 hands this to whatever the launch file starts, too.
        os.environ["OVERRIDE_LAUNCH_PROCESS_OUTPUT"] = "both"
    if PRINT[0] in request.options:
        from launcher.commands import plan

        return plan.show(request, patience)
    return launch(request, options, patience)


def usage() -> str:
    """What `--help` prints."""
    from launcher.commands.launch.options import HELP

    return "\n".join([_USAGE.format(run_help=HELP), "", *exit_code_table()])


def _take_run_options(words: Sequence[str]) -> tuple[RunOptions, list[str]]:
    """(the options about the run in `words`, the words that are something else); UsageError."""
    if any(word.startswith("-") for word in words):
        from launcher.commands.launch.options import take_run_options

        return take_run_options(words)
    return RunOptions(), list(words)


def _with_prefix(request: LaunchRequest) -> LaunchRequest:
    """The request with the launch configurations that the prefix options stand for."""
    prefix = request.options.get(PREFIX[0])
    pattern = request.options.get(PREFIX_FILTER[0])
    if prefix is None:
        if pattern is not None:
            raise UsageError(
                "--launch-prefix must be specified if --launch-prefix-filter is provided"
            )
        return request
    more = [("launch-prefix", prefix)]
    if pattern is not None:
        more.append(("launch-prefix-filter", pattern))
    return LaunchRequest(
        path=request.path, arguments=(*request.arguments, *more), options=request.options
    )


def launch(request: LaunchRequest, options: RunOptions, patience: TimeLimit) -> int:
    """Evaluate the launch file, then run what it describes."""
    from launcher import frontends
    from launcher.engine.runfolder import new_run_path
    from launcher.interpreter import Interpreter
    from launcher.language.compat import vocabulary

    run_path = new_run_path(os.environ) if options.log_files else None
    words = [request.path, *(f"{name}:={value}" for name, value in request.arguments)]
    with vocabulary(words) as session:
        # Launch files ask where the logs of their run are.
        session.log_dir = None if run_path is None else str(run_path)
        with limited(patience, request.path):
            description = frontends.load(request.path)
            if LENIENT[0] not in request.options and not _declares(description, request):
                _refuse_unknown(request)
                description = frontends.load(request.path)  # the plan has used the first one up
        interpreter = Interpreter(
            description,
            path=request.path,
            arguments=request.arguments,
            noninteractive=NONINTERACTIVE[0] in request.options or not _has_terminal(),
        )
        try:
            core = _SoundCore(interpreter, description, request, patience)
            core.evaluate()
            core.refuse_domain()
            if options.required:
                core.refuse_missing(options)
            code = _supervise(core, options, run_path, request)
        finally:
            interpreter.close()
    if interpreter.failure is not None:
        print(interpreter.failure.render(), file=sys.stderr)
        return ExitCode.PROCESS_FAILED
    return code


def _has_terminal() -> bool:
    return sys.stdin is not None and sys.stdin.isatty()


# ---- before anything starts


def _declares(description: LaunchDescription, request: LaunchRequest) -> bool:
    """Whether all arguments are plainly declared, so that no dry run is needed to know them."""
    names = {name for name, _ in request.arguments}
    if not names:
        return True
    try:
        declared = description.get_launch_arguments()
    except Exception:
        return True  # the run finds out, and says where
    return names <= {argument.name for argument in declared}


def _refuse_unknown(request: LaunchRequest) -> None:
    """An error if, as a dry run shows, nothing declares or reads one of the arguments."""
    from launcher.commands.launch import mistakes
    from launcher.commands.launch.known_names import known_names
    from launcher.commands.launch.redirection import silence
    from launcher.planner import make_plan

    with silence():
        plan = make_plan(request.path, request.arguments)
        known = known_names(plan)
    errors = mistakes.unknown_names(request.arguments, known, plan.declared)
    if not errors:
        return
    if plan.error is not None:
        errors += mistakes.of_launch_file(
            plan.error.fault, plan.description, plan.context, request.arguments, os.environ
        )
    raise mistakes.together(errors)


class _SoundCore:
    """The interpreter, whose start is limited in time and tells all mistakes at once."""

    def __init__(
        self,
        interpreter: Interpreter,
        description: LaunchDescription,
        request: LaunchRequest,
        patience: TimeLimit,
    ) -> None:
        self._interpreter = interpreter
        self._description = description
        self._request = request
        self._patience = patience
        self._effects: Sequence[Effect] = ()
        self._story: list[tuple[float, int | None, Sequence[Effect]]] = []

    def evaluate(self) -> None:
        """Visit the static part, before there is a run with files and processes; LauncherError."""
        try:
            with limited(self._patience, self._request.path):
                self._effects = self._interpreter.start()
        except LaunchFileError as fault:
            raise self._explained(fault) from fault

    def refuse_domain(self) -> None:
        """UsageError if the environment names a ROS domain in which no node can start."""
        word = self._interpreter.environment.get("ROS_DOMAIN_ID", "")
        if not word or (word.isdecimal() and len(word) < 3):
            return  # nearly always, and nothing is imported for it
        from launcher.commands.launch import ros_domain

        ros_domain.refuse(word, self._effects)

    def refuse_missing(self, options: RunOptions) -> None:
        """UsageError if a required process is not started, and nothing could start it later."""
        from launcher.engine.unmatched import nearest
        from launcher.language.actions.process import TargetedHandler
        from launcher.language.handlers import OnIncludeLaunchDescription, OnShutdown
        from launcher.model.events import LogMessage, StartProcess
        from launcher.model.options import matches

        harmless = (OnIncludeLaunchDescription, OnShutdown, TargetedHandler)
        if not all(isinstance(effect, (StartProcess, LogMessage)) for effect in self._effects):
            return  # a timer, a component
        if any(type(one) not in harmless for one in self._interpreter.context._event_handlers):
            return
        specs = [one.spec for one in self._effects if isinstance(one, StartProcess)]
        for pattern in options.required:
            if not any(matches(pattern, spec) for spec in specs):
                names = ", ".join(spec.name for spec in specs) or "none"
                raise UsageError(
                    f"--required '{pattern}' fits no process{nearest(pattern, specs)}",
                    hint=f"processes there are: {names}",
                )

    def start(self) -> Sequence[Effect]:
        """The effects of the launch file's static part."""
        self._story.append((time.monotonic(), None, self._effects))
        return self._effects

    def _explained(self, fault: LaunchFileError) -> LauncherError:
        from launcher.commands.launch import mistakes

        errors = mistakes.of_launch_file(
            fault,
            self._description,
            self._interpreter.context,
            self._request.arguments,
            os.environ,
        )
        return mistakes.together(errors)

    def handle(self, event: Event) -> Sequence[Effect]:
        """The effects of what happened."""
        effects = self._interpreter.handle(event)
        if effects and len(self._story) < MOST_CHAPTERS:
            self._story.append((time.monotonic(), _ended_process(event), effects))
        return effects

    def watches_output(self, process_id: int) -> bool:
        """Whether the launch file wants the output of this process."""
        return self._interpreter.watches_output(process_id)

    def plan(self) -> Mapping[str, Any]:
        """The plan document of what was asked for so far."""
        from launcher.commands.launch.run_plan import Chapter, run_document

        story = [Chapter(*chapter) for chapter in self._story]
        return run_document(self._interpreter, self._request.path, story)

    def plan_lines(self) -> Sequence[str]:
        """The same for people."""
        from launcher.commands.launch.run_plan import Chapter, run_text

        story = [Chapter(*chapter) for chapter in self._story]
        return run_text(self._interpreter, self._request.path, story)


def _ended_process(event: Event) -> int | None:
    """The process whose end this event tells."""
    from launcher.model.events import ProcessExited, SpawnFailed

    return event.process_id if isinstance(event, (ProcessExited, SpawnFailed)) else None


def _supervise(
    core: _SoundCore, options: RunOptions, run_path: Path | None, request: LaunchRequest
) -> ExitCode:
    from launcher.engine.reactor import Reactor
    from launcher.engine.screen import Screen, passes_colour, wants_colour
    from launcher.engine.supervisor import Supervisor

    environment = dict(os.environ)
    run_id = _new_run_id()
    with Reactor() as reactor:
        plain = not passes_colour(1, environment)
        screen = Screen(reactor, colour=wants_colour(1, environment), plain=plain)
        supervisor = Supervisor(
            core,
            env=environment,
            reactor=reactor,
            screen=screen,
            run_id=run_id,
            run_path=run_path,
            options=options,
        )
        if not options.control:
            return supervisor.run()
        started = time.time()
        company: list[Helpers] = []

        def attend() -> None:
            from launcher.commands.launch.helpers import Helpers

            attendants = Helpers(
                supervisor,
                reactor=reactor,
                screen=screen,
                options=options,
                environment=environment,
            )
            company.append(attendants)
            attendants.open(request, run_id=run_id, started=started)

        supervisor.on_begun = lambda: reactor.call_later(ATTEND_AFTER_S, attend)
        try:
            return supervisor.run()
        finally:
            for attendants in company:
                attendants.close()


def _new_run_id() -> str:
    return f"{os.getpid()}-{os.urandom(6).hex()}"
