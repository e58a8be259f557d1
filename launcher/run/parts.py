"""The table of the parts that a run may have, with their options; `part_verbs` has their verbs."""

from __future__ import annotations

import os

from launcher.base.model.run_options import RunOptions
from launcher.base.option import Option, count, lazy, load, option, positive_seconds, seconds
from launcher.run.part import (
    CONTROL,
    DEVELOPMENT,
    HOSTS,
    LOOKING,
    RESOURCES,
    RESTARTS,
    STARTS,
    PartRow,
    When,
)
from launcher.run.part_options import (
    CHAOS,
    COMPOSE,
    DISCOVERY,
    PRIVATE,
    RECORDING,
    SKIP_HOST,
    page_options,
)

# Doors of wings for the evaluation of a launch file, and the program of composed nodes.
prepared_hosts = lazy("launcher.hosts.launching.hosts_preparation:HostsPreparation")
planned_hosts = lazy("launcher.hosts.launching.planned_hosts:PlannedHosts")
with_expectations_beside = lazy("launcher.faults.watch_options:with_expectations_beside")
private_domain = lazy("launcher.ros.discovery.free_domain:of_run")
open_node = lazy("launcher.ros.helpers.spinning_node:SpinningNode")
COMPOSED = "launcher.ros.composed"


def _loses_byte_code() -> bool:
    """Whether Python may have compiled this module in vain."""
    cached = __spec__.cached if __spec__ is not None else None
    return "PYTHONDONTWRITEBYTECODE" in os.environ or not os.path.exists(cached or "")


# In the order in which the hooks of parts are called, and in which starts go through those that are
# stages. Parts are closed in the opposite order.
ROWS = (
    PartRow(
        "launcher.run.monitor.housekeeping:Housekeeping", imports=("launcher.run.monitor.ledger",)
    ),
    PartRow(
        "launcher.hosts.engine.fleet:Fleet",
        When.FIRST,
        lambda run: run.launched.hosts is not None,
        group=HOSTS,
        options=(
            option(
                "--hosts FILE", "run processes on other hosts, as this file says", repeat="once"
            ),
            SKIP_HOST,
            DISCOVERY,
        ),
    ),
    PartRow(
        "launcher.run.private_domain:PrivateDomain",
        When.FIRST,
        lambda run: run.options.private,
        group=STARTS,
        options=(PRIVATE,),
        check="launcher.run.private_domain:check",
    ),
    PartRow(
        "launcher.run.compose.composed_members:ComposedMembers",
        When.FIRST,
        lambda run: run.options.compose,
        group=RESOURCES,
        options=(COMPOSE,),
    ),
    PartRow("launcher.run.ready.gate:ReadyGate", When.FIRST, lambda run: run.options.start_rules),
    PartRow(
        "launcher.run.starts.pacing:StartPacing",
        When.FIRST,
        lambda run: run.options.stagger_s > 0 or run.options.max_starting is not None,
        group=STARTS,
        options=(
            option(
                "--stagger S", "start processes at least S seconds apart", seconds, name="stagger_s"
            ),
            option(
                "--max-starting N",
                "let at most N processes start at the same time",
                lambda word: count(word, 1),
            ),
        ),
    ),
    PartRow(
        "launcher.run.starts.warm_starts:WarmStarts",
        When.FIRST,
        lambda run: run.options.warm is not False,
        group=STARTS,
        options=(
            option(
                "--warm",
                "start all Python programs warm, from a process that has imported what they need; "
                "without --warm and --cold, Python nodes where that is faster",
                value=True,
            ),
            option("--cold", "start no process warm", name="warm", value=False),
        ),
    ),
    PartRow(
        "launcher.run.time_limits:RunTimeout",
        When.FIRST,
        lambda run: run.options.timeout_s is not None,
        group=RESTARTS,
        options=(
            option(
                "--timeout S", "end the run after S seconds", positive_seconds, name="timeout_s"
            ),
        ),
    ),
    PartRow(
        "launcher.run.time_limits:QuietLimit",
        When.FIRST,
        lambda run: run.options.stop_after_quiet_s is not None,
        group=RESTARTS,
        options=(
            option(
                "--stop-after-quiet SECONDS",
                "end the run when its processes have written nothing for so long",
                positive_seconds,
                name="stop_after_quiet_s",
            ),
        ),
    ),
    PartRow(
        "launcher.run.monitor.enforcement:BudgetEnforcement",
        When.FIRST,
        lambda run: run.options.has_budgets,
        group=RESOURCES,
        options=(
            option(
                "--budget NAME:cpu=80%,memory=200M,threads=N,fds=N,for=S,"
                "action=warn|restart|stop-run",
                "limit what a process may use, checked once a second",
                name="budgets",
            ),
        ),
    ),
    PartRow(
        "launcher.run.plan_file:PlanFile",
        When.FIRST,
        lambda run: run.log_dir is not None or run.options.name_processes,
    ),
    PartRow("launcher.run.requests.process_control:ProcessControl", When.ASKED),
    PartRow(
        "launcher.ros.discovery.introductions:ParticipantIntroductions",
        wanted=lambda run: run.options.introduce and run.has_nodes,
        imports=("launcher.posix.ports", "launcher.ros.discovery.rtps"),
        group=STARTS,
        options=(
            option(
                "--no-introductions",
                "do not help new nodes to discover those that run already",
                name="introduce",
                value=False,
            ),
        ),
    ),
    PartRow(
        "launcher.run.helpers.parameter_checks:ParameterChecks",
        wanted=lambda run: run.options.check_parameters,
        group=DEVELOPMENT,
        options=(
            option(
                "--no-parameter-check",
                "do not warn of parameters that were set and that their nodes do not declare",
                name="check_parameters",
                value=False,
            ),
        ),
    ),
    PartRow(
        "launcher.run.helpers.namesake_checks:NamesakeChecks",
        wanted=lambda run: run.options.check_domain and not run.options.private,
        delay_s=0.3,  # leaves the processor to processes that are starting
        group=DEVELOPMENT,
        options=(
            option(
                "--no-domain-check",
                "do not warn of nodes of other runs with the names of nodes of this one",
                name="check_domain",
                value=False,
            ),
        ),
    ),
    PartRow(
        "launcher.run.byte_code_notice:ByteCodeNotice",
        wanted=lambda run: (
            _loses_byte_code() and not (run.launched.is_script or run.launched.is_test)
        ),
        delay_s=0.3,  # leaves the processor to processes that are starting
    ),
    PartRow("launcher.run.reload.reload:Reloader", When.ASKED),
    PartRow(
        "launcher.run.watch.watching:Watching",
        wanted=lambda run: run.options.watch,
        delay_s=0.05,
        group=DEVELOPMENT,
        options=(
            option(
                "--watch",
                "restart processes when their source or parameter files change, and reload the "
                "launch file when that does",
            ),
        ),
        check="launcher.run.watch:check",
    ),
    PartRow(
        "launcher.run.monitor.responsiveness:Responsiveness",
        wanted=lambda run: run.options.responsive,
        delay_s=2.0,  # nodes are starting before, and cannot be late
        group=LOOKING,
        options=(
            option(
                "--responsive",
                "warn of nodes that do not answer any more, with their stacks (30 MB; `top` and "
                "`--web` do it, too)",
            ),
        ),
    ),
    PartRow("launcher.run.stacks.stacks:Stacks", When.ASKED),
    PartRow("launcher.run.helpers.logger_levels:LoggerLevels", When.ASKED),
    PartRow("launcher.smoke.inject.injections:Injections", When.ASKED),
    PartRow(
        "launcher.smoke.inject.chaos_run:ChaosRun",
        wanted=lambda run: run.options.chaos_plan,
        group=DEVELOPMENT,
        options=(CHAOS,),
        check="launcher.smoke.inject.chaos_run:check",
    ),
    PartRow(
        "launcher.web.web_page:WebPage",
        When.SERVED,
        lambda run: run.options.web,
        group=LOOKING,
        options=(
            option(
                "--web",
                "serve a page in the browser that shows and controls this run",
            ),
            *page_options("web-"),
        ),
        check="launcher.web.page_options:check",
    ),
    PartRow(
        "launcher.control.control_server:ControlSocket",
        wanted=lambda run: run.options.control,
        delay_s=0.05,
        imports=(
            "_socket",
            "selectors",
            "socket",
            "launcher.control.verbs",
            "launcher.control.status",
            "launcher.control.log_followers",
            "launcher.run.requests.request_queue",
            "launcher.run.requests.process_control",
            "launcher.control.control_service",
        ),
        group=CONTROL,
        options=(
            option(
                "--no-control",
                "open no socket for other shells; implies --no-console",
                name="control",
                value=False,
            ),
        ),
    ),
    PartRow(
        "launcher.bag.flight.flight_recorder:FlightRecorderProcess",
        When.SERVED,
        lambda run: run.options.record is not None,
        group=LOOKING,
        options=RECORDING,
        check="launcher.bag.flight.recording:check",
    ),
    PartRow(
        "launcher.faults.fault_watch:FaultWatch",
        When.SERVED,
        lambda run: run.options.watchful or run.options.expect is not None,
        delay_s=0.3,  # leaves the processor to processes that are starting
        group=LOOKING,
        options=(
            option(
                "--expect FILE",
                "watch the run: report what does not hold of the expectations in this file, as "
                "for `smoke`",
                repeat="once",
            ),
            option(
                "--watchful",
                "watch the run, with NAME.expect.yaml beside the launch file if there is one",
            ),
        ),
        check="launcher.faults.watch_options:check",
    ),
    PartRow(
        "launcher.faults.actions.fault_actions:FaultActions",
        When.SERVED,
        lambda run: (
            run.options.watchful or run.options.expect is not None or run.options.fault_actions
        ),
        delay_s=0.3,  # as what it listens to
    ),
    PartRow(
        "launcher.faults.actions.fault_actions:UnwatchedActions",
        wanted=lambda run: run.options.fault_actions and not run.options.control,
        delay_s=0.3,
    ),
    PartRow(
        "launcher.ros.bridge_process:RosBridge",
        When.SERVED,
        lambda run: run.options.ros,
        group=CONTROL,
        options=(
            option(
                "--ros",
                "start a node /launcher that publishes /diagnostics and offers services to start, "
                "stop and restart processes, for rqt and Foxglove",
            ),
        ),
        check="launcher.ros.bridge_process:check",
    ),
    PartRow(
        "launcher.control.console_process:ConsoleProcess",
        When.SERVED,
        lambda run: run.options.console and run.screen.is_tty and os.isatty(0),
        delay_s=0.3,  # leaves the processor to processes that are starting
        group=CONTROL,
        options=(
            option(
                "--no-console", "disable the prompt and the status bar", name="console", value=False
            ),
        ),
    ),
)


def part_options(group: str) -> tuple[Option, ...]:
    """The options that are shown in this group."""
    return tuple(option for row in ROWS if row.group == group for option in row.options)


def check_options(options: RunOptions) -> None:
    """UsageError for options of parts that exclude each other, or that lack a library."""
    for row in ROWS:
        if row.check and any(
            getattr(options, one.name) != getattr(RunOptions, one.name) for one in row.options
        ):
            load(row.check)(options)
