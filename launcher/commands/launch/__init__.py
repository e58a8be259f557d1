"""`launch TARGET [name:=value ...]`: run a launch file until its processes have ended."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from launcher.command_line import Command, option
from launcher.commands import VERBS
from launcher.commands.launch.options import RUN_OPTIONS, run_options
from launcher.commands.launch.target import (
    ABOUT_TARGET,
    READING_OPTIONS,
    SYNOPSIS,
    TARGET,
    LaunchRequest,
)
from launcher.commands.launch.time_limit import limited
from launcher.errors import (
    ExitCode,
    LaunchFileError,
    UsageError,
    exit_code_table,
)
from launcher.model.options import RunOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.commands.launch.helpers import Helpers
    from launcher.commands.launch.run_plan import RunStep
    from launcher.interpreter import Interpreter
    from launcher.language.description import LaunchDescription
    from launcher.model.events import Effect, Event

# What serves the control socket takes 15 ms to import; the first processes start meanwhile.
HELPERS_DELAY_S = 0.05
MAX_RECORDED_STEPS = 2000  # bounds the memory for the plan of a run

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
        option(
            "-a, --show-all-subprocesses-output",
            "send the output of every process to the screen and to the log",
            name="show_all",
        ),
        *READING_OPTIONS,
    ),
    groups=(("options about the run", RUN_OPTIONS),),
    epilog="\n".join(exit_code_table()),
)


def main(words: Sequence[str]) -> int:
    """Run the launch file that `words` name; the exit code."""
    parsed = COMMAND.parse(words)
    options = run_options(parsed)
    request = LaunchRequest.of(parsed)
    if parsed.show_args:
        from launcher.commands import args

        return args.show(request)
    if parsed.show_all:
        # Launch files hand the environment on to other launchers, as with ROS 2.
        os.environ["OVERRIDE_LAUNCH_PROCESS_OUTPUT"] = "both"
    if parsed.print_plan:
        from launcher.commands import plan

        return plan.show(request)
    return launch(request, options)


def launch(request: LaunchRequest, options: RunOptions) -> int:
    """Evaluate the launch file, then run what it describes."""
    from launcher import frontends
    from launcher.engine.logs.run_directory import new_run_path
    from launcher.interpreter import Interpreter
    from launcher.language.compat import vocabulary

    run_path = new_run_path(os.environ) if options.log_files else None
    words = [request.path, *(f"{name}:={value}" for name, value in request.arguments)]
    with vocabulary(words) as session:
        # Launch files ask where the logs of their run are.
        session.log_dir = None if run_path is None else str(run_path)
        with limited(request.time_limit, request.path):
            description = frontends.load(request.path)
            if not request.lenient and not _is_declared(request, description):
                _refuse_unknown(request)
                description = frontends.load(request.path)  # the plan has used the first one up
        interpreter = Interpreter(
            description,
            path=request.path,
            arguments=request.arguments,
            noninteractive=request.noninteractive or not _has_terminal(),
        )
        try:
            core = LaunchCore(interpreter, description, request)
            core.evaluate()
            core.refuse_domain()
            if options.required:
                core.refuse_missing(options.required)
            code = _supervise(core, options, run_path, request)
        finally:
            interpreter.close()
    if interpreter.failure is not None:
        print(interpreter.failure.render(), file=sys.stderr)
        return ExitCode.PROCESS_FAILED
    return code


def _has_terminal() -> bool:
    return sys.stdin is not None and sys.stdin.isatty()


def _is_declared(request: LaunchRequest, description: LaunchDescription) -> bool:
    """Whether the launch file declares all given arguments, so that no dry run is needed."""
    names = {name for name, _ in request.arguments}
    if not names:
        return True
    try:
        declared = description.get_launch_arguments()
    except Exception:
        return True  # the run reports it, with its place
    return names <= {argument.name for argument in declared}


def _refuse_unknown(request: LaunchRequest) -> None:
    """LauncherError if a dry run shows that nothing declares or reads one of the arguments."""
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


class LaunchCore:
    """An interpreter whose start is limited in time, and which records what the run did."""

    def __init__(
        self, interpreter: Interpreter, description: LaunchDescription, request: LaunchRequest
    ) -> None:
        self._interpreter = interpreter
        self._description = description
        self._request = request
        self._effects: Sequence[Effect] = ()
        # (time, process that ended or None, effects) of each step
        self._steps: list[tuple[float, int | None, Sequence[Effect]]] = []

    def evaluate(self) -> None:
        """Visit the static part, before there is a run with files and processes; LauncherError."""
        try:
            with limited(self._request.time_limit, self._request.path):
                self._effects = self._interpreter.start()
        except LaunchFileError as fault:
            from launcher.commands.launch import mistakes

            errors = mistakes.of_launch_file(
                fault,
                self._description,
                self._interpreter.context,
                self._request.arguments,
                os.environ,
            )
            raise mistakes.together(errors) from fault

    def refuse_domain(self) -> None:
        """UsageError if the environment names a ROS domain in which no node can start."""
        word = self._interpreter.environment.get("ROS_DOMAIN_ID", "")
        if not word or (word.isdecimal() and len(word) < 3):
            return  # nearly always, and nothing is imported for it
        from launcher.commands.launch import ros_domain

        ros_domain.refuse(word, self._effects)

    def refuse_missing(self, required: Sequence[str]) -> None:
        """UsageError if a required process is not started, and nothing could start it later."""
        from launcher.engine.option_warnings import nearest
        from launcher.language.actions.process import TargetedHandler
        from launcher.language.event_handlers import OnIncludeLaunchDescription, OnShutdown
        from launcher.model.events import LogMessage, StartProcess
        from launcher.model.options import matches

        harmless = (OnIncludeLaunchDescription, OnShutdown, TargetedHandler)
        if not all(isinstance(effect, (StartProcess, LogMessage)) for effect in self._effects):
            return  # a timer, a component
        if any(type(one) not in harmless for one in self._interpreter.event_handlers):
            return
        specs = [one.spec for one in self._effects if isinstance(one, StartProcess)]
        for pattern in required:
            if not any(matches(pattern, spec) for spec in specs):
                names = ", ".join(spec.name for spec in specs) or "none"
                raise UsageError(
                    f"--required '{pattern}' fits no process{nearest(pattern, specs)}",
                    hint=f"processes: {names}",
                )

    def start(self) -> Sequence[Effect]:
        """The effects of the launch file's static part."""
        self._steps.append((time.monotonic(), None, self._effects))
        return self._effects

    def handle(self, event: Event) -> Sequence[Effect]:
        """The effects of what happened."""
        effects = self._interpreter.handle(event)
        if effects and len(self._steps) < MAX_RECORDED_STEPS:
            self._steps.append((time.monotonic(), _ended_process(event), effects))
        return effects

    def watches_output(self, process_id: int) -> bool:
        """Whether the launch file wants the output of this process."""
        return self._interpreter.watches_output(process_id)

    def plan(self) -> Mapping[str, Any]:
        """The plan document of the run so far."""
        from launcher.commands.launch.run_plan import run_document

        return run_document(self._interpreter, self._request.path, self._recorded())

    def plan_lines(self) -> Sequence[str]:
        """The same as a tree, line by line."""
        from launcher.commands.launch.run_plan import run_text

        return run_text(self._interpreter, self._request.path, self._recorded())

    def _recorded(self) -> list[RunStep]:
        from launcher.commands.launch.run_plan import RunStep

        return [RunStep(*step) for step in self._steps]


def _ended_process(event: Event) -> int | None:
    """The process whose end this event tells."""
    from launcher.model.events import ProcessExited, SpawnFailed

    return event.process_id if isinstance(event, (ProcessExited, SpawnFailed)) else None


def _supervise(
    core: LaunchCore, options: RunOptions, run_path: Path | None, request: LaunchRequest
) -> ExitCode:
    from launcher.engine.output.stdout import StdoutWriter, passes_colour, wants_colour
    from launcher.engine.posix.reactor import Reactor
    from launcher.engine.supervisor import Supervisor

    environment = dict(os.environ)
    run_id = _new_run_id()
    with Reactor() as reactor:
        plain = not passes_colour(1, environment)
        screen = StdoutWriter(reactor, colour=wants_colour(1, environment), plain=plain)
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
        opened: list[Helpers] = []

        def open_helpers() -> None:
            from launcher.commands.launch.helpers import Helpers

            helpers = Helpers(
                supervisor,
                reactor=reactor,
                screen=screen,
                options=options,
                environment=environment,
            )
            opened.append(helpers)
            helpers.open(request, run_id=run_id, started=started)

        supervisor.on_begun = lambda: reactor.call_later(HELPERS_DELAY_S, open_helpers)
        try:
            return supervisor.run()
        finally:
            for helpers in opened:
                helpers.close()


def _new_run_id() -> str:
    return f"{os.getpid()}-{os.urandom(6).hex()}"
