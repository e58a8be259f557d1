"""The verbs about a running launch: one table for requests of programs and for command lines."""

from __future__ import annotations

import math
import signal
from collections.abc import Iterable, Mapping, Sequence

from launcher.base.command_line import Command, HelpRequested, Parsed
from launcher.base.errors import UsageError
from launcher.base.option import Option, count, option, positive_seconds
from launcher.base.run_verb import FOR_ALL, TEXT, BadCallError, Call, Verb
from launcher.base.text import did_you_mean
from launcher.run import part_verbs

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


FOLLOW = option("-f, --follow", "keep printing new entries until the run ends")
SIGNAL = option(
    "-s, --signal SIGNAL",
    "send this signal instead, once; also as -15 or -TERM; 0 only tests whether it is running",
    kind="signal",
)
AS_CRASH = option(
    "--as-crash",
    "an exit by the signal counts as a crash, and the restart policy applies",
)
LINES = option(
    "-n, --lines N",
    "print the last N lines (default: 100, with -f 10)",
    count,
    kind="count",
)
MAX_RATE = option(
    "--max-rate N",
    "with -f: leave out lines of a process that writes more than N in a second, and say how many",
    count,
    kind="count",
)
PERIOD = option(
    "-p, --period S",
    "seconds between two samples (default: 1)",
    positive_seconds,
    name="period_s",
    kind="seconds",
)
RESPONSIVE = option("--responsive", "ask the nodes first whether they answer (up to 10 s)")
NEW = option("--new", "only events from now on", name="history", value=False)
LEVEL = option("LEVEL", "DEBUG, INFO, WARN, ERROR, FATAL, or ALL")
FORMAT = option("FORMAT", "default, compact, or a template with {message}")
PATTERN = option("PATTERN", "a regular expression")
TOPIC = option("TOPIC", "a verb, or `all`")
EVERYTHING = "all"  # in place of a verb: the table of all


def signal_number(word: str) -> int:
    """15 for `SIGTERM`, `TERM`, `term` and `15`, 0 for `0`; BadCallError."""
    name = word.upper()
    if word == "0":
        return 0  # as with kill(1): tests whether it exists
    if word.isdecimal() and len(word) < 4 and int(word) in signal.valid_signals():
        return int(word)
    for spelling in (name, f"SIG{name}"):
        if spelling in signal.Signals.__members__:
            return int(signal.Signals[spelling])
    names = [one.name for one in signal.Signals]
    hint = did_you_mean(name, names) or did_you_mean(f"SIG{name}", names)
    known = f"known: {', '.join(names)}"
    raise BadCallError("bad-option", f"unknown signal '{word}'", hint or known)


def _signal_shorthand(word: str) -> tuple[Option, str] | None:
    """`-9` and `-TERM`, as with kill(1); an invalid number is rejected later."""
    try:
        signal_number(word[1:])
    except BadCallError:
        return (SIGNAL, word[1:]) if word[1:].isdecimal() else None
    return SIGNAL, word[1:]


VERBS = (
    Verb(
        "ps [NAME ...] [--responsive]",
        "list processes with state, restarts, CPU and memory (USS)",
        (RESPONSIVE,),
    ),
    Verb("top [NAME ...]", "list processes live", (FOLLOW, PERIOD), streams=True),
    Verb(
        "kill NAME ... [-s SIGNAL]",
        "send processes SIGKILL, or exactly one other signal",
        (SIGNAL, AS_CRASH),
        shorthand=_signal_shorthand,
    ),
    Verb("stop NAME ...", "stop processes: SIGINT, then SIGTERM, then SIGKILL"),
    Verb("start NAME ...", "start processes that have ended"),
    Verb("restart NAME ...", "stop processes and start them again"),
    Verb("pause NAME ...", "suspend processes (SIGSTOP)"),
    Verb("resume NAME ...", "resume suspended processes (SIGCONT)"),
    Verb("mute NAME ...", "hide the output of processes; it is still written to the log files"),
    Verb("unmute [NAME ...]", "show the output of processes again, and end `solo`"),
    Verb("solo NAME ...", "show the output of these processes only"),
    Verb(
        "level [LEVEL [NAME ...]]",
        "show only lines of LEVEL and above; without it, print the level",
        (LEVEL,),
    ),
    Verb(
        "grep [PATTERN [NAME ...]]", "show only lines that match; without PATTERN, all", (PATTERN,)
    ),
    Verb("show", "show all output again: end `mute`, `solo`, `level` and `grep`"),
    Verb(
        "format [FORMAT]",
        "show lines as `compact`, `default` or by a template; without it, print the format",
        (FORMAT,),
    ),
    Verb(
        "logs [NAME ...] [-n N] [-f] [--max-rate N]",
        "print the last lines of processes, hidden ones too",
        (LINES, FOLLOW, MAX_RATE),
        streams=True,
    ),
    Verb("info NAME ...", "show everything known about processes"),
    Verb("send NAME TEXT", "send a line to the standard input of a process", rest=TEXT),
    Verb(
        "events [-f] [--new]",
        "print starts, exits, restarts, signals and resources",
        (FOLLOW, NEW),
        streams=True,
    ),
    *part_verbs.VERBS,
    Verb("plan", "show what the launch file has done so far", shell=False),
    Verb("pick", "open the list of processes below the output (also F2)", shell=False),
    Verb("quit", "stop everything and end the run"),
    Verb(
        "help [all|VERB]",
        "show the verbs that are used most, all of them, or how one is used",
        (TOPIC,),
        shell=False,
    ),
)


ALIASES = {"exit": "quit", "q": "quit", "?": "help", "w": "web"}  # as in other prompts
# Verbs that change nothing, without the options that `Verb.changing` names.
READ_ONLY = frozenset({"ps", "top", "logs", "info", "events", "faults", "stack", "plan", "help"})


def only_reads(name: str, options: Mapping[str, Any]) -> bool:
    """Whether a request changes nothing; False for an unknown verb."""
    verb = find(name)
    if verb is None or verb.name not in READ_ONLY:
        return False
    return all(options.get(one) is None for one in verb.changing)


def find(name: str) -> Verb | None:
    """The verb with this name."""
    name = ALIASES.get(name, name)
    return next((verb for verb in VERBS if verb.name == name), None)


def known(name: str) -> Verb:
    """The verb with this name; BadCallError."""
    verb = find(name)
    if verb is None:
        names = [one.name for one in VERBS]
        from launcher.base.synonyms import meant_verb  # only mistakes need it

        hint = meant_verb(name, names) or f"known: {', '.join(names)}"
        raise BadCallError("unknown-verb", f"unknown verb '{name}'", hint)
    return verb


def explained(verb: Verb) -> str:
    """Its line of help, with its other names."""
    others = [alias for alias, name in ALIASES.items() if name == verb.name]
    return f"{verb.help}; also: {', '.join(others)}" if others else verb.help


def manual(verb: Verb) -> list[str]:
    """How a verb is used in the console, line by line."""
    from launcher.base.command_help import help_text

    return help_text(verb.command()).split("\n")


# ---- requests


def check(name: str, names: Sequence[str], options: Mapping[str, Any]) -> Call:
    """The call that a request asks for; BadCallError."""
    verb = known(name)
    _check_names(verb, names)
    checked = {}
    for key, value in options.items():
        option = verb.option(key)
        if option is None:
            raise BadCallError(
                "bad-option", f"{name} has no option '{key}'", f"usage: {verb.usage}"
            )
        if value is not None:
            checked[key] = _checked(verb, option, value)
    if verb.rest is not None and verb.rest.count == "1" and verb.rest.name not in checked:
        problem = f"{name} needs {verb.rest.metavar}: {verb.rest.help}"
        raise BadCallError("bad-option", problem, f"usage: {verb.usage}")
    return Call(verb, tuple(names), checked)


def _check_names(verb: Verb, names: Sequence[str]) -> None:
    problem, more = None, ""
    if verb.names == "none" and names:
        problem = f"{verb.name} takes no names"
    elif verb.names in ("one", "some") and not names:
        problem = f"{verb.name} needs the name of a process"
        more = f"; {FOR_ALL}" if verb.names == "some" else ""
    elif verb.names in ("one", "perhaps") and len(names) > 1:
        problem = f"{verb.name} takes one name"
    if problem is not None:
        raise BadCallError("bad-request", problem, f"usage: {verb.usage}{more}")


def _checked(verb: Verb, option: Option, value: Any) -> Any:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    match option.kind:
        case "flag" if isinstance(value, bool):
            return value
        case "text" if isinstance(value, str):
            return value
        case "count" if is_number and isinstance(value, int) and value >= 0:
            return value
        case "seconds" if is_number and value > 0 and math.isfinite(value):
            return float(value)
        case "signal" if isinstance(value, (int, str)) and not isinstance(value, bool):
            return signal_number(str(value))
    raise BadCallError("bad-option", f"{verb.name}: '{option.name}' {_EXPECTED[option.kind]}")


_EXPECTED = {
    "flag": "must be true or false",
    "text": "must be a string",
    "count": "must be a whole number of at least 0",
    "seconds": "must be a number of seconds above 0",
    "signal": "must be a signal",
}


# ---- command lines


def parse(verb: Verb, words: Iterable[str]) -> Call:
    """The call that the words behind a verb stand for in the console; UsageError."""
    try:
        return call_of(verb, parsed_by(verb.command(), list(words)))
    except HelpRequested:
        return check("help", (), {TOPIC.name: verb.name})


def parsed_by(command: Command, words: Sequence[str]) -> Parsed:
    """The words behind the verb of this command; UsageError, HelpRequested."""
    try:
        return command.parse(words)
    except UsageError as error:
        if command.name == FORMAT.name and any("{" in word for word in words[1:]):
            error.hint = "a template with blanks needs quotes: format '{clock} {message}'"
        raise


def call_of(verb: Verb, parsed: Parsed) -> Call:
    """The call that parsed words stand for; UsageError."""
    given = vars(parsed)
    options = {one.name: value for one, _, value in parsed.given if one in verb.options}
    if verb.argument is not None and given[verb.argument] is not None:
        options[verb.argument] = given[verb.argument]
    if verb.text is not None and given[verb.text]:
        options[verb.text] = " ".join(given[verb.text])
    words = [given[one.name] for one in verb.behind if given[one.name] is not None]
    last = verb.behind[len(verb.behind) - len(words) :]
    options.update((one.name, word) for one, word in zip(last, words, strict=True))
    names = given.get("names") or []
    try:
        return check(verb.name, [names] if isinstance(names, str) else names, options)
    except BadCallError as error:
        raise UsageError(error.message, hint=error.hint) from None
