"""Which verbs are tools: made from the rows of verbs, so that a new row is a new tool.

The verbs of the control socket are offered unless `LEFT_OUT` says why not; of the verbs of a shell,
those of `_SHELL`.
"""

from __future__ import annotations

import importlib

from launcher.base.command_line import Command
from launcher.base.model.record import Record, replace
from launcher.base.option import Option
from launcher.base.run_verb import FOR_ALL, TEXT, Verb
from launcher.base.verb_table import module_of
from launcher.control import verb as control_verb
from launcher.control import verbs
from launcher.web.remote.argument import ToolArgument
from launcher.web.remote.tool import RUN, Tool

LIMIT_S = 120.0  # for a request to a run
USUAL_WAIT_S, LONGEST_WAIT_S = 60, 600  # of the verb `wait`
_GRAPH_S = 60.0
MOST_ITEMS = 1000  # in an answer of a verb that streams
_USUAL_ITEMS = 100
LIMIT = "limit"

_SCREEN = "changes what the screen of the run shows, which a program does not see"
_SHELL_ONLY = "starts programs or writes files: it is for a shell"
_ROS = "one of many commands about ROS, for a shell; `graph` has nodes, topics and services"
_REASONS = {
    _SCREEN: "mute unmute solo level grep show format",
    "`ps` answers the same, once": "top",
    "is for the keyboard of the console": "pick",
    "the list of tools says it": "help",
    "a person takes the processes up again, with `attach`": "detach",
    "an editor is to be connected": "debug",
    "a page for people, and a server that goes on": "web foxglove mcp",
    _SHELL_ONLY: "launch args run demo build wheel pkg env test bag doctor hosts attach analyze "
    "smoke launch-test export incident",
    _ROS: "topic node param service action lifecycle interface tf",
    "is internal": "multicast daemon agent completion",
}
# Verbs that are no tools, each with the reason.
LEFT_OUT = {verb: reason for reason, names in _REASONS.items() for verb in names.split()}
# Options of streams: a tool answers once, with the last items.
OF_STREAMS = frozenset({"follow", "max_rate", "history", "period_s", "lines"})


class _ShellRow(Record):
    """A command of a shell that is a tool; `left_out` are options that it does not get.

    `timeout`: the option that limits it, which a call may set.
    """

    name: str
    limit_s: float
    left_out: frozenset[str]
    timeout: str = ""


# The answer is JSON; the run, and with it the domain, is chosen by the argument `run`.
_COMMON = frozenset({"json", "debug", "help", "workspace", "run", "domain"})
_OF_ROS = frozenset({"no_observer", "no_daemon", "use_sim_time"})
_DRAWINGS = frozenset({"dot", "mermaid", "svg", "html"})
_SHELL = (
    _ShellRow("runs", LIMIT_S, _COMMON),
    _ShellRow("graph", _GRAPH_S, _COMMON | _OF_ROS | _DRAWINGS | {"watch", "period", "diff"}),
    _ShellRow("wait", LONGEST_WAIT_S + 10.0, _COMMON, timeout="timeout"),
)


def tools(*, read_only: bool = False, chooses_run: bool = True) -> dict[str, Tool]:
    """All tools by name; with `read_only` those that change nothing.

    With `chooses_run` the run is an argument of each call. Otherwise there is only one, and tools
    about several are left out.
    """
    offered = [_of_verb(verb, read_only=read_only) for verb in verbs.VERBS if is_offered(verb)]
    offered += [_of_shell(row) for row in _SHELL if chooses_run or row.name != "runs"]
    choice = ToolArgument(RUN, "text", "id, pid or target of the run, if several are active")
    found = {}
    for tool in offered:
        if tool.is_read_only or not read_only:
            more = (choice,) if chooses_run and tool.name != "runs" else ()
            found[tool.name] = replace(tool, arguments=(*tool.arguments, *more))
    return found


def is_offered(verb: Verb) -> bool:
    """Whether a verb of the control socket is a tool."""
    return verb.name not in LEFT_OUT


def _of_verb(verb: Verb, *, read_only: bool) -> Tool:
    is_read_only = verb.name in verbs.READ_ONLY and (read_only or not verb.changing)
    kept = [
        one
        for one in (*verb.options, *verb.behind)
        if not (verb.streams and one.name in OF_STREAMS)
        and not (read_only and one.name in verb.changing)
    ]
    arguments = [*_names(verb), *map(_of_option, kept)]
    if verb.rest is not None:  # its choices are those of the first word
        rest = replace(ToolArgument.of(verb.rest), choices=(), is_required=verb.rest == TEXT)
        arguments.append(rest)
    if verb.streams:
        help_text = "how many of the last entries are wanted"
        arguments.append(
            ToolArgument(LIMIT, "count", help_text, default=_USUAL_ITEMS, most=MOST_ITEMS)
        )
    changing = verb.changing if verb.name in verbs.READ_ONLY else ()
    return Tool(
        verb.name,
        verb.help,
        tuple(arguments),
        is_read_only,
        LIMIT_S,
        verb,
        about=_about(verb),
        changing=changing,
    )


def _about(verb: Verb) -> str:
    return control_verb.NAMES.replace("\n", " ") if verb.names != "none" else ""


def _of_option(option: Option) -> ToolArgument:
    return replace(ToolArgument.of(option), is_required=option == TEXT)


def _names(verb: Verb) -> list[ToolArgument]:
    if verb.names == "none":
        return []
    is_required = verb.names in ("one", "some")
    most = 1 if verb.names in ("one", "perhaps") else None
    help_text = {
        "one": "the process",
        "perhaps": "the process, if it is about one",
        "some": f"the processes; {FOR_ALL}",
        "any": "the processes; without it, all",
    }[verb.names]
    return [ToolArgument("names", "texts", help_text, is_required, most=most)]


def command_of(name: str) -> Command:
    """The command line of a verb of a shell."""
    if name == control_verb.RUNS.name:
        return control_verb.RUNS
    found: Command = importlib.import_module(module_of(name)).COMMAND
    return found


def _of_shell(row: _ShellRow) -> Tool:
    command = command_of(row.name)
    kept = [one for one in command.all_options if one.name not in row.left_out]
    arguments = [_limited(one, row) for one in (*command.arguments, *kept)]
    flags = {one.name: one.flags[-1] for one in kept}
    return Tool(row.name, command.help, tuple(arguments), True, row.limit_s, flags=flags)


def _limited(option: Option, row: _ShellRow) -> ToolArgument:
    found = ToolArgument.of_words(option)
    if option.name != row.timeout:
        return found
    return replace(found, default=USUAL_WAIT_S, most=LONGEST_WAIT_S, help="give up after S seconds")
