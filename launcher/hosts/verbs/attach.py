"""`attach [RUN]`: return to a run whose processes were left on other hosts."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Mapping, Sequence

from launcher.base.command_line import Command
from launcher.base.errors import (
    OF_SMOKE,
    ExitCode,
    LauncherError,
    UsageError,
    exit_code_table,
)
from launcher.base.model.events import (
    Effect,
    Event,
    RequestShutdown,
    ShutdownAsked,
    SignalReceived,
    StartProcess,
)
from launcher.base.model.spec import OutputPolicy, ProcessSpec
from launcher.base.option import count, option
from launcher.base.text import escape
from launcher.base.verb_table import VERBS
from launcher.hosts.engine.fleet import FleetPlan
from launcher.hosts.engine.link import Attached
from launcher.hosts.engine.systemd import found_runs
from launcher.hosts.engine.systemd.found_runs import FoundRun
from launcher.hosts.file.hosts_reader import read
from launcher.hosts.file.order import Order
from launcher.hosts.verbs.hosts_options import DEFAULT, hosts_path
from launcher.language.launch_session import LaunchSession
from launcher.launch.launch_core import launched, supervising
from launcher.launch.launch_options import RUN_OPTIONS, run_options
from launcher.launch.target import DEBUG, LaunchRequest
from launcher.output.logs.run_directory import new_run_path, provide_log_root
from launcher.run.ending import shutdown_machine

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

LINES = 10
# What decides how a run is started has been decided.
_OPTIONS = tuple(
    one
    for one in RUN_OPTIONS
    if one.name
    in {"hosts", "required", "exit_when_any_dies", "timeout_s", "format", "log_files", "console"}
    or one.name == "control"
)
COMMAND = Command(
    "attach",
    VERBS["attach"],
    arguments=(option("[RUN]"),),
    synopsis="[RUN] [--hosts FILE] [options]",
    about=f"""\
Follow and control a run that was detached, or whose launcher was lost: its processes live on as
units of systemd. RUN is its id; it may be left out if there is only one. The hosts are those of
FILE (default: {DEFAULT}).

Ctrl-C stops the run on all hosts, as it does for `launch`; `detach` leaves it again.""",
    options=(
        option("-n, --lines N", f"begin with the last N lines (default: {LINES})", count),
        option("-l, --list", "list the runs, and attach to none", name="is_list"),
        option("--stop", "stop the run, also one that is left of a lost launcher", name="stops"),
        DEBUG,
    ),
    groups=(("options about the run", _OPTIONS),),
    epilog="\n".join(exit_code_table(code for code in ExitCode if code not in OF_SMOKE)),
)


def main(words: Sequence[str]) -> int:
    parsed = COMMAND.parse(words)
    options = run_options(parsed)
    hosts = read(hosts_path(options.hosts), with_secrets=False).hosts
    found = found_runs.find(list(hosts.values()))
    for warning in found.warnings:
        print(f"warning: {escape(warning)}", flush=True)
    if parsed.is_list:
        where = " on the hosts that can be reached" if found.warnings else ""
        print("\n".join(_rows(found.runs) or [f"no runs{where}"]))
        return ExitCode.OK
    run = _chosen(found.runs, parsed.run, bool(found.warnings))
    if parsed.stops:
        return _stop(run)
    request = LaunchRequest(path=run.title or run.run)
    plan = FleetPlan(
        host_of=lambda spec: run.hosts[run.host_of[spec.name]],
        needed=tuple(run.hosts.values()),
        title=run.title,
        attached=Attached(run.run, LINES if parsed.lines is None else parsed.lines),
        orders={order.name: order for order in run.orders.values()},
    )
    provide_log_root(os.environ)
    run_path = new_run_path(os.environ) if options.log_files else None
    core = AttachedCore(run)
    what = launched(
        request,
        path=run_path,
        session=LaunchSession(),  # the language has no part in it
        hosts=plan,
        run_id=f"{os.getpid()}-{run.run}",
        not_begun="not attached",
    )
    with supervising(core, options, what) as (supervisor, _):
        return supervisor.run()


def _chosen(found: Sequence[FoundRun], wanted: str | None, is_partial: bool) -> FoundRun:
    """UsageError if it is not clear which, LauncherError if there is none."""
    short = None if wanted is None else wanted.rpartition("-")[2]  # as `runs` shows it, too
    fitting = [one for one in found if short is None or one.run.startswith(short)]
    if len(fitting) == 1:
        return fitting[0]
    if not found:
        where = "the hosts that can be reached" if is_partial else "the hosts"
        raise LauncherError(f"there is no run on {where}")
    rows = "\n".join(_rows(found))
    if not fitting:
        raise UsageError(f"there is no run '{wanted}'", hint=f"runs on the hosts:\n{rows}")
    raise UsageError("there are several runs", hint=f"name one:\n{rows}")


def _rows(found: Iterable[FoundRun]) -> list[str]:
    return [
        f"{one.run}  {time.strftime('%Y-%m-%d %H:%M:%S', time.localtime(one.started))}"
        f"  {one.title}  by {one.operator}  on {', '.join(one.hosts)}"
        for one in found
    ]


def _stop(run: FoundRun) -> int:
    print(f"stopping run {run.run} ({run.title})", flush=True)
    failures = found_runs.stop(run)
    for failure in failures:
        print(f"error: {escape(failure)}", flush=True)
    return ExitCode.PROCESS_FAILED if failures else ExitCode.OK


class AttachedCore:
    """In place of an interpreter: the processes of the run, and nothing else will happen."""

    has_failed = False

    def __init__(self, run: FoundRun) -> None:
        self._run = run

    def start(self) -> Sequence[Effect]:
        ordered = sorted(self._run.orders.items(), key=lambda item: item[1].number)
        return [StartProcess(process_id=number, spec=spec_of(one)) for number, one in ordered]

    def handle(self, event: Event) -> Sequence[Effect]:
        if isinstance(event, (ShutdownAsked, SignalReceived)):
            return [RequestShutdown(reason=shutdown_machine.IDLE)]
        return ()

    def watches_output(self, process_id: int) -> bool:
        return False

    def intentions(self) -> Sequence[str]:
        return ()

    def plan(self) -> Mapping[str, Any]:
        return {"title": self._run.title, "processes": sorted(self._run.host_of)}

    def plan_lines(self) -> Sequence[str]:
        return [f"attached to run {self._run.run}: {self._run.title}"]


def spec_of(order: Order) -> ProcessSpec:
    """What is known of the process here, not its environment; all of its output is shown."""
    words = ("".join(map(_shown, word)) for word in order.words)
    return ProcessSpec(
        name=order.name,
        label=order.label,
        argv=tuple(words),
        env={},
        cwd=order.cwd,
        shell=order.shell,
        output=OutputPolicy.named("both"),
        restart=order.restart,
        stop=order.stop,
        limits=order.limits,
    )


def _shown(part: object) -> str:
    if isinstance(part, str):
        return part
    name = getattr(part, "name", None) or getattr(part, "path", None)
    return str(name or "python3")
