"""The verbs that parts of a run bring, in the order of the table `parts`.

Nobody can use one before the control socket is open, so this is imported behind the first start.
"""

from __future__ import annotations

from launcher.base.option import Option, count, lazy, option
from launcher.base.run_verb import Verb

DRY_RUN = option("--dry-run", "only show what would be done")
STATE = option("STATE", "on or off")
FOLLOW = option("-f, --follow", "keep printing changes until the run ends")
WHAT = option(
    "[WHAT]",
    "pause, slow FACTOR, kill, drop TOPIC [PERCENT], delay TOPIC MS, cpu [CORES], memory SIZE, or "
    "disk [LEAVE]",
    choices=("pause", "slow", "kill", "drop", "delay", "cpu", "memory", "disk"),
)


def _for_time(doc: str) -> Option:
    """`--for TIME`, in seconds."""
    parse = lazy("launcher.base.document.quantities:parse_positive_duration")
    return option("--for TIME", doc, parse, name="for_s", kind="seconds")


VERBS = (
    Verb(
        "detach",
        "end the run here, and let the processes on other hosts run on",
        serve="launcher.hosts.engine.detach_verb:serve",
    ),
    Verb(
        "reload [--dry-run]",
        "evaluate the launch file again: start what is new, stop what is gone, restart "
        "what has changed",
        (DRY_RUN,),
        serve="launcher.run.reload.reload:serve",
    ),
    Verb(
        "watch [on|off] [NAME ...]",
        "restart processes when their files change; without on and off, show what is watched",
        (STATE,),
        serve="launcher.run.watch.verb:serve",
    ),
    Verb(
        "stack NAME ... [--native] [--locals]",
        "print the Python stacks of all threads of processes",
        (
            option("--native", "with the calls of C and C++ code between them"),
            option("--locals", "with the local variables of each call"),
        ),
        serve="launcher.run.stacks.stacks:serve",
    ),
    Verb(
        "debug NAME [--port N] [--no-wait]",
        "start or restart a Python process under debugpy, for an editor to attach",
        (
            option(
                "--port N",
                "listen at this port of 127.0.0.1 (default: a free one)",
                count,
                kind="count",
            ),
            option(
                "--no-wait",
                "run at once, without waiting for an editor",
                name="wait",
                value=False,
            ),
        ),
        serve="launcher.run.debug.verb:serve",
    ),
    Verb(
        "loglevel NAME [LOGGER] [LEVEL]",
        "set from which level on nodes log; without LEVEL, print it",
        behind=(
            option("[LOGGER]", "a logger, as in its lines; default: that of the node"),
            option("[LEVEL]", "debug, info, warn, error or fatal"),
        ),
        serve="launcher.run.helpers.logger_levels:serve",
    ),
    Verb(
        "web",
        "open the page of this run in the browser",
        shell=False,
        serve="launcher.web.web_page:serve",
    ),
    Verb(
        "faults [-f] [--mute FAULT]",
        "list what is wrong in a watched run, and why",
        (
            FOLLOW,
            option("--acknowledge FAULT", "somebody takes care of it"),
            option("--mute FAULT", "report it no more: no lines, no actions"),
            option("--unmute FAULT", "report it again"),
            _for_time(
                "with --mute: the seconds until it is reported again; on a command line also 2min"
            ),
            option("--reason TEXT", "with --acknowledge and --mute: why"),
        ),
        streams=True,
        shell=False,
        changing=("acknowledge", "mute", "unmute", "for_s", "reason"),
        serve="launcher.faults.fault_watch:serve",
    ),
    Verb(
        "inject [NAME] [WHAT] [--for TIME] [--end]",
        "inject a fault into a process, or the `machine`, for a while; without WHAT, list those "
        "that are active",
        (
            _for_time("how many seconds (default: 5); on a command line also 500ms or 2min"),
            option("--end", "end those of NAME, or all, before their time"),
        ),
        rest=WHAT,
        serve="launcher.smoke.inject.injections:serve",
    ),
    Verb(
        "snapshot [REASON]",
        "write the last messages, logs and events of a run with --record",
        (option("REASON", "why, for the index of the snapshot"),),
        serve="launcher.bag.flight.flight_recorder:serve",
    ),
)
