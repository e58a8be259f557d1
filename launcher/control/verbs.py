"""Verbs: the one table of what a person can ask of a running run, and how its words are read."""

from __future__ import annotations

import math
import signal
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from launcher.errors import UsageError, nearest
from launcher.model.record import Record


class Option(Record):
    """An option of a verb. `kind`: flag, text, count, seconds or signal.

    `name` is its name in a request, `flags` are its words on a command line, of which a flag sets
    `value`. Without flags it is an argument of the verb, or for programs alone.
    """

    name: str
    kind: str
    help: str
    flags: tuple[str, ...] = ()
    metavar: str = ""
    value: bool = True


class Verb(Record):
    """A verb: how it is written, and what it takes.

    `names` says how many processes it wants: none, one, some (at least one) or any (none stands
    for all). `argument` is the option that the first word gives (it may be left out where
    `argument_optional`), `text` the one that all words behind the name give. `streams`: with the
    option `follow` it does not end. `shell`: it is a command of its own, too.
    """

    name: str
    usage: str
    help: str
    names: str = "none"
    options: tuple[Option, ...] = ()
    argument: str | None = None
    argument_optional: bool = False
    text: str | None = None
    streams: bool = False
    shell: bool = True

    def option(self, name: str) -> Option | None:
        """The option with this name in requests."""
        return next((option for option in self.options if option.name == name), None)


FOLLOW = Option("follow", "flag", "go on with what comes", ("-f", "--follow"))
SIGNAL = Option("signal", "signal", "exactly this signal, once", ("-s", "--signal"), "SIGNAL")
LINES = Option("lines", "count", "the last N lines (100)", ("-n", "--lines"), "N")
PERIOD = Option("period_s", "seconds", "seconds between two looks (1)", ("-p", "--period"), "S")
NEW = Option("history", "flag", "only what comes from now on", ("--new",), value=False)
LEVEL = Option("level", "text", "DEBUG, INFO, WARN, ERROR, FATAL, or ALL")
PATTERN = Option("pattern", "text", "a regular expression")
TEXT = Option("text", "text", "a line for its standard input")
TOPIC = Option("topic", "text", "the verb that is meant")

VERBS = (
    Verb("ps", "ps [NAME ...]", "list processes with state, restarts, CPU and memory", "any"),
    Verb("top", "top [NAME ...]", "the same, live", "any", (FOLLOW, PERIOD), streams=True),
    Verb(
        "kill",
        "kill NAME ... [-s SIGNAL]",
        "stop processes, or send them exactly one signal",
        "some",
        (SIGNAL,),
    ),
    Verb("stop", "stop NAME ...", "stop processes: SIGINT, then SIGTERM, then SIGKILL", "some"),
    Verb("start", "start NAME ...", "start processes that have ended", "some"),
    Verb("restart", "restart NAME ...", "stop processes and start them again", "some"),
    Verb("pause", "pause NAME ...", "let processes stand still (SIGSTOP)", "some"),
    Verb("resume", "resume NAME ...", "let paused processes go on (SIGCONT)", "some"),
    Verb("mute", "mute NAME ...", "show nothing of processes; their files go on", "some"),
    Verb("unmute", "unmute [NAME ...]", "show them again, and end `solo`", "any"),
    Verb("solo", "solo NAME ...", "show these processes alone", "some"),
    Verb(
        "level",
        "level [LEVEL [NAME ...]]",
        "show only lines of this level and above; ALL shows all; alone: what is shown",
        "any",
        (LEVEL,),
        argument="level",
        argument_optional=True,
    ),
    Verb(
        "grep",
        "grep [PATTERN [NAME ...]]",
        "show only lines in which this is found; without it, all",
        "any",
        (PATTERN,),
        argument="pattern",
        argument_optional=True,
    ),
    Verb(
        "logs",
        "logs [NAME ...] [-n N] [-f]",
        "the last lines of processes, whatever is shown of them",
        "any",
        (LINES, FOLLOW),
        streams=True,
    ),
    Verb("info", "info NAME ...", "all that is known of a process", "some"),
    Verb("send", "send NAME TEXT", "a line for its standard input", "one", (TEXT,), text="text"),
    Verb(
        "events",
        "events [-f] [--new]",
        "starts, ends, restarts, signals and resources",
        options=(FOLLOW, NEW),
        streams=True,
    ),
    Verb("plan", "plan", "what the launch file has asked for so far", shell=False),
    Verb("quit", "quit", "stop everything and end the run"),
    Verb(
        "help",
        "help [VERB]",
        "this table, or how one verb is used",
        options=(TOPIC,),
        argument="topic",
        argument_optional=True,
        shell=False,
    ),
)


ALIASES = {"exit": "quit", "?": "help"}  # what people type into any prompt
HELP_FLAGS = ("-h", "--help")
LOOKING = frozenset({"ps", "top", "logs", "info", "events"})  # they change nothing


class Call(Record):
    """A verb with what it is asked about: the body of a request."""

    verb: Verb
    names: tuple[str, ...]
    options: Mapping[str, Any]


class BadCallError(Exception):
    """What was asked for makes no sense; `code` is the protocol's."""

    def __init__(self, code: str, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.hint = hint


def find(name: str) -> Verb | None:
    """The verb with this name."""
    name = ALIASES.get(name, name)
    return next((verb for verb in VERBS if verb.name == name), None)


def known(name: str) -> Verb:
    """The verb with this name; BadCallError."""
    verb = find(name)
    if verb is None:
        names = [one.name for one in VERBS]
        near = nearest(name, names)
        hint = f"there are {', '.join(names)}" if near is None else f"did you mean {near}?"
        raise BadCallError("unknown-verb", f"there is no verb '{name}'", hint)
    return verb


def manual(verb: Verb) -> list[str]:
    """How a verb is used: what `VERB --help` says of it alone, line by line."""
    lines = [f"usage: {verb.usage}", f"{verb.help[0].upper()}{verb.help[1:]}."]
    for option in verb.options:
        if option.flags:
            words = ", ".join(option.flags) + (f" {option.metavar}" if option.metavar else "")
            lines.append(f"  {words:<20} {option.help}")
    return lines


# ---- from a program


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
    for needed in (verb.text, None if verb.argument_optional else verb.argument):
        if needed is not None and needed not in checked:
            raise BadCallError(
                "bad-option", f"{name} needs {_named(verb, needed)}", f"usage: {verb.usage}"
            )
    return Call(verb, tuple(names), checked)


def _named(verb: Verb, name: str) -> str:
    option = verb.option(name)
    return name if option is None else f"{name.upper()}: {option.help}"


def _check_names(verb: Verb, names: Sequence[str]) -> None:
    problem = None
    if verb.names == "none" and names:
        problem = f"{verb.name} takes no names"
    elif verb.names in ("one", "some") and not names:
        problem = f"{verb.name} needs the name of a process"
    elif verb.names == "one" and len(names) > 1:
        problem = f"{verb.name} takes one name"
    if problem is not None:
        raise BadCallError("bad-request", problem, f"usage: {verb.usage}")


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
    raise BadCallError("bad-option", f"{verb.name}: '{option.name}' is {_MEANT[option.kind]}")


_MEANT = {
    "flag": "true or false",
    "text": "a text",
    "count": "a whole number, not negative",
    "seconds": "a number of seconds above 0",
    "signal": "a signal",
}


def signal_number(word: str) -> int:
    """15 for `SIGTERM`, `TERM`, `term` and `15`, 0 for `0`; BadCallError."""
    name = word.upper()
    if word == "0":
        return 0  # as with kill: whether it is there
    if word.isdecimal() and len(word) < 4 and int(word) in signal.valid_signals():
        return int(word)
    for spelling in (name, f"SIG{name}"):
        if spelling in signal.Signals.__members__:
            return int(signal.Signals[spelling])
    names = [one.name for one in signal.Signals]
    near = nearest(name, names) or nearest(f"SIG{name}", names)
    hint = f"there are {', '.join(names)}" if near is None else f"did you mean {near}?"
    raise BadCallError("bad-option", f"there is no signal '{word}'", hint)


# ---- from a person


def parse(verb: Verb, words: Iterable[str]) -> Call:
    """The call that the words behind a verb stand for; UsageError."""
    queue = deque(words)
    plain: list[str] = []
    options: dict[str, Any] = {}
    while queue:
        word = queue.popleft()
        if word == "--" or (plain and verb.text is not None):
            plain += queue if word == "--" else [word, *queue]
            break
        if word in HELP_FLAGS:
            return check("help", (), {TOPIC.name: verb.name})
        if word.startswith("-") and len(word) > 1:
            _take(verb, word, queue, options)
        else:
            plain.append(word)
    if verb.argument is not None and plain:
        options[verb.argument] = plain.pop(0)
    if verb.text is not None and len(plain) > 1:
        options[verb.text] = " ".join(plain[1:])
        del plain[1:]
    try:
        return check(verb.name, plain, options)
    except BadCallError as error:
        raise UsageError(error.message, hint=error.hint) from None


def _take(verb: Verb, word: str, queue: deque[str], options: dict[str, Any]) -> None:
    flag, has_value, value = word.partition("=")
    option = next((one for one in verb.options if flag in one.flags), None)
    if option is None and SIGNAL in verb.options and _is_signal(word[1:]):
        options[SIGNAL.name] = word[1:]  # `kill -9`, `kill -TERM`: fingers know it
        return
    if option is None or (has_value and option.kind == "flag"):
        is_name = verb.names != "none" and len(word) > 2 and not word.startswith("--")
        behind = "; a name that begins with '-' goes behind --" if is_name else ""
        raise UsageError(f"{verb.name} has no option '{word}'", hint=f"usage: {verb.usage}{behind}")
    if option.kind == "flag":
        options[option.name] = option.value
        return
    if not has_value:
        if not queue:
            raise UsageError(f"{flag} needs a value: {option.metavar}", hint=f"usage: {verb.usage}")
        value = queue.popleft()
    options[option.name] = _from_text(option, flag, value)


def _is_signal(word: str) -> bool:
    try:
        signal_number(word)
    except BadCallError:
        return word.isdecimal()  # it is meant as one, and is told to be none
    return True


def _from_text(option: Option, flag: str, text: str) -> Any:
    read = {"count": int, "seconds": float}.get(option.kind, str)
    try:
        return _within(option, read(text))
    except ValueError:
        raise UsageError(f"{flag} is {_MEANT[option.kind]}, not '{text}'") from None


def _within(option: Option, value: Any) -> Any:
    """The value; ValueError if it is too small, or no number that one can wait for."""
    if option.kind == "count" and value < 0:
        raise ValueError
    if option.kind == "seconds" and not (value > 0 and math.isfinite(value)):
        raise ValueError
    return value
