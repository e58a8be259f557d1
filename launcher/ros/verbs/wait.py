"""`wait [NAME ...]`: wait for processes of a run, and for the ROS graph; for scripts."""

from __future__ import annotations

import functools
import os
import re
import sys
from collections.abc import Callable

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, LauncherError, UsageError
from launcher.base.model.ros_names import full_name
from launcher.base.model.supervision import Fact
from launcher.base.option import DEBUG, JSON, Option, option, positive_seconds
from launcher.base.verb_table import VERBS
from launcher.posix.json_output import print_document
from launcher.posix.reactor import Reactor
from launcher.ros.verb import dispatch, domain_option
from launcher.ros.waiting import STATES, Awaited, ConditionWait

_DOMAIN = option(
    "-d, --domain ID", "ROS domain (default: that of the run with NAME, else ROS_DOMAIN_ID)"
)
_NAME = re.compile(r"/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)
_PATTERN = re.compile(r"[\w/*?\[\]!-]+", re.ASCII)
_ABOUT = """\
Wait until all of it holds. NAME is a process of a run as for `ps`; the run may begin later. With
several runs, choose one with --run.

Exit codes: 0 it holds; 1 it can no longer hold, since a process or the run has ended; 2 bad command
line; 124 it did not hold in time."""


class NotInTime(LauncherError):
    """It did not hold before the timeout."""

    exit_code = ExitCode.NOT_READY


def _named(flag: str) -> Callable[[str], str]:
    form = _PATTERN if flag == "--node" else _NAME

    def read(word: str) -> str:
        if not word.strip("/"):
            raise ValueError(f"the name behind {flag} is missing")
        if not form.fullmatch(word):
            raise ValueError(f"'{word}' cannot be the name of a {flag.lstrip('-')}")
        return full_name(word)

    return read


def _facts(options: Parsed) -> list[Fact]:
    return [
        *(Fact("publisher", name) for name in options.topics),
        *(Fact("service", name, call=False) for name in options.services),
        *(Fact("node", name) for name in options.nodes),
    ]


def _wait(options: Parsed) -> int:
    facts = _facts(options)
    if not options.names and not facts:
        hint = "name a process, or use --topic, --service or --node"
        raise UsageError("nothing to wait for", hint=hint)
    if not options.names and (options.state or options.run):
        raise UsageError("the NAME of a process is missing", hint="for example: wait robot_1")
    if options.domain is not None:
        os.environ["ROS_DOMAIN_ID"] = str(domain_option(options))
    state = options.state or STATES[0]
    with (
        Reactor() as reactor,
        ConditionWait(reactor, options.names, state, facts, options.run) as waiting,
    ):
        return _until(options, reactor, waiting)


def _until(options: Parsed, reactor: Reactor, waiting: ConditionWait) -> int:
    begun_s = reactor.now()
    reported: set[int] = set()

    def changed() -> None:
        found = waiting.conditions
        for place, condition in enumerate(found):
            if condition.holds and place not in reported and not options.json:
                reported.add(place)
                print(f"{condition.text} ({reactor.now() - begun_s:.1f} s)", flush=True)
        if all(one.holds for one in found) or any(one.is_lost for one in found):
            reactor.stop()

    suspected: set[str] = set()

    def suspect(condition: Awaited) -> None:
        if condition.name not in suspected:
            suspected.add(condition.name)
            print(f"note: {condition.text}", file=sys.stderr, flush=True)

    waiting.changed, waiting.suspect = changed, suspect
    if options.timeout is not None:
        reactor.call_later(options.timeout, reactor.stop)
    waiting.begin()
    reactor.run()
    return _concluded(options, waiting, reactor.now() - begun_s)


def _concluded(options: Parsed, waiting: ConditionWait, waited_s: float) -> int:
    missing = [one for one in waiting.conditions if not one.holds]
    if options.json:
        found = [one.document() for one in waiting.conditions]
        document = {"holds": not missing, "waited_s": round(waited_s, 3), "conditions": found}
        print_document(document)
    lost = [one.text for one in missing if one.is_lost]
    if lost:
        raise LauncherError("; ".join(lost))
    if missing:
        texts = "; ".join(one.text for one in missing)
        raise NotInTime(f"not within {options.timeout:g} s: {texts}")
    return ExitCode.OK


def _seen(flag: str, help_text: str) -> Option:
    name = flag.lstrip("-")
    spelling = f"{flag} {name.upper()}"
    return option(spelling, help_text, _named(flag), (), name=f"{name}s", repeat="all")


COMMAND = Command(
    "wait",
    VERBS["wait"],
    arguments=(option("[NAME ...]", "process, label, node or pattern", name="names"),),
    options=(
        option("--state STATE", "of the processes (default: running)", choices=STATES),
        _seen("--topic", "it has a publisher"),
        _seen("--service", "it is offered"),
        _seen("--node", "it is in the graph; also a pattern"),
        option("--timeout S", "give up after S seconds (default: never)", positive_seconds),
        option("--run ID", "id, pid or target of the run, or the beginning of one of these"),
        _DOMAIN,
        JSON,
        DEBUG,
    ),
    about=_ABOUT,
    run=_wait,
)

main = functools.partial(dispatch, COMMAND)
