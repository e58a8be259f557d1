"""Which candidates fit at a place of a command line, by the tables that parse it."""

from __future__ import annotations

import importlib
import re
from collections.abc import Iterable, Iterator, Sequence

from launcher.base.command_line import Command
from launcher.base.errors import LauncherError, UsageError
from launcher.base.option import WORKSPACE, Option
from launcher.base.verb_table import CONTROL_VERBS, ROS_FRONT, ROS_VERBS, VERBS
from launcher.cli.completion import name_sources
from launcher.cli.lookup import command_of
from launcher.cli.workspace_option import choose_workspace
from launcher.run.part_verbs import WHAT

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable


Candidate = tuple[str, str]  # (the whole word, one line about it)

# By the placeholder of an option or argument. Where it is NAME, by the verb.
_BY_METAVAR: dict[str, Callable[[str], Iterable[Candidate]]] = {
    "FILE": name_sources.files,
    "DIR": name_sources.folders,
    "SIGNAL": name_sources.signals,
    "LEVEL": name_sources.levels,
    "PACKAGE": name_sources.packages,
    "NODE": name_sources.nodes,
    "TYPE": name_sources.types,
    "TOPIC": name_sources.topics,
    "ID": name_sources.runs,
    "ARG": name_sources.files,
    "BAG": name_sources.files,
    "OTHER": name_sources.files,
    "URI": name_sources.files,
    "OUT": name_sources.files,
}
_BY_VERB: dict[str, Callable[[str], Iterable[Candidate]]] = {
    "topic": name_sources.topics,
    "node": name_sources.nodes,
    "service": name_sources.services,
    "action": name_sources.actions,
}


def candidates(words: Sequence[str]) -> Iterable[Candidate]:
    """Candidates for the last of `words`, those behind the program; LauncherError."""
    *before, current = words
    if before[:1] == ["--"]:
        before = before[1:]
    flag = WORKSPACE.flags[0]
    if before[-1:] == [flag]:
        return name_sources.folders(current)
    if any(word.partition("=")[0] == flag for word in before):
        before = _in_workspace(before)
    if not before:
        return _first(current)
    if before[0].startswith("-"):
        try:
            before = importlib.import_module(ROS_FRONT).verb_first(before)
        except UsageError:  # the verb is still to come
            return [(verb, VERBS[verb]) for verb in ROS_VERBS]
    command, rest = command_of(before)
    if command.commands and not rest:
        return [(each.name.rpartition(" ")[2], each.help) for each in command.commands]
    return _CursorPlace(command, rest).candidates(current)


def _in_workspace(words: Sequence[str]) -> list[str]:
    """The words without --workspace, which is entered; LauncherError."""
    from launcher.packages import activation
    from launcher.packages.workspace import current

    left = choose_workspace(words)
    workspace = current()
    if workspace is not None:
        activation.activate(workspace)
    return left


def _first(current: str) -> Iterator[Candidate]:
    if current.startswith("-"):
        yield from (("--help", "show the verbs"), ("--version", "print the version"))
        yield WORKSPACE.flags[0], WORKSPACE.help
        return
    from launcher.control.verb import RUNS
    from launcher.control.verbs import VERBS as CONTROL

    yield from VERBS.items()
    yield from ((verb.name, verb.help) for verb in CONTROL if verb.shell)
    yield RUNS.name, RUNS.help
    yield from name_sources.targets(current)


class _CursorPlace:
    """What the words before the cursor say about the one at the cursor."""

    def __init__(self, command: Command, words: Sequence[str]) -> None:
        self._command = command
        self._flags = {flag: one for one in command.all_options for flag in one.flags}
        self._plain: list[str] = []
        self._pending: Option | None = None
        self._takes_options = True
        self._run: str | None = None
        for word in words:
            self._take(word)

    def _take(self, word: str) -> None:
        pending, self._pending = self._pending, None
        flag, has_value, value = word.partition("=")
        known = self._flags.get(flag) if self._takes_options else None
        if pending is not None:
            if pending.name == "run":
                self._run = word
        elif word == "--" and self._takes_options:
            self._takes_options = False
        elif known is None:
            if not (self._takes_options and word.startswith("-")):
                self._plain.append(word)
        elif has_value:
            self._run = value if known.name == "run" else self._run
        elif not known.is_flag and known.count != "=":
            self._pending = known

    def candidates(self, current: str) -> Iterable[Candidate]:
        if self._pending is not None:
            return self._values(self._pending, current)
        flag, has_value, value = current.partition("=")
        if self._takes_options and current.startswith("-"):
            if has_value and flag in self._flags:
                found = self._values(self._flags[flag], value)
                return [(f"{flag}={one}", text) for one, text in found]
            return [(flag, one.help) for flag, one in self._flags.items()]
        arguments = self._command.arguments
        if not arguments:
            return []
        last = arguments[-1]
        place = len(self._plain)
        if place >= len(arguments) and last.count not in ("*", "+", "..."):
            return []
        return self._values(arguments[min(place, len(arguments) - 1)], current)

    def _values(self, option: Option, current: str) -> Iterable[Candidate]:
        if option.choices:
            return [(choice, "") for choice in option.choices]
        metavar = option.metavar.partition("=")[0].partition("[")[0]
        verb = self._command.name.partition(" ")[0]
        if metavar == "TARGET":
            return name_sources.launch_words(self._plain, current)
        if metavar == "EXECUTABLE":
            return name_sources.executables(self._plain[0])
        if metavar == "PARAMETER":
            return name_sources.parameters(self._plain[0])
        if metavar == "TRANSITION":
            return name_sources.transitions(self._plain[0])
        if metavar == "NODE" and verb == "lifecycle":
            return name_sources.lifecycle_nodes(current)
        if metavar == "TYPE" and verb in ("service", "action"):
            return name_sources.types_of(verb, self._plain)
        if verb == "loglevel" and metavar in ("LOGGER", "LEVEL"):
            return name_sources.logger_levels(current)  # the logger may be left out
        if verb == "inject" and metavar == "WHAT":
            return [(word, "") for word in WHAT.choices] if len(self._plain) == 1 else []
        if metavar == "NAME" and not option.flags:
            if verb in CONTROL_VERBS:
                return name_sources.processes(self._run)
            return _BY_VERB[verb](current) if verb in _BY_VERB else []
        if metavar == "ID" and option.name != "run":
            return []  # of a domain
        return _BY_METAVAR[metavar](current) if metavar in _BY_METAVAR else []


# ---- the answer to a shell

_SPECIAL = re.compile(r"([^\w@%+:,./=\-])")
_OPEN_ENDS = (":=", "=", "/")  # more of the word follows


def answer(shell: str, words: Sequence[str]) -> str:
    """The lines for `words`: for bash its line and COMP_WORDBREAKS, else those behind the program.

    Nothing, if the launch file or the run cannot be read: the command itself will say why.
    """
    try:
        if shell == "bash":
            lines = list(bash_lines(*words[:2]))
        else:
            lines = [f"{value}\t{text}".rstrip("\t") for value, text in found(words)]
    except (LauncherError, OSError):
        return ""
    return "".join(f"{line}\n" for line in lines)


def found(words: Sequence[str]) -> list[Candidate]:
    """The candidates that begin with the last word, each once; texts in one line."""
    unique: dict[str, str] = {}
    for value, text in candidates(words):
        if value.startswith(words[-1]) and "\n" not in value:
            unique.setdefault(value, " ".join(text.split()))
    return list(unique.items())


def bash_lines(line: str, breaks: str = "") -> Iterable[str]:
    """Completions for a command line up to the cursor.

    readline replaces only what follows the last of its `breaks`, unless the word is quoted.
    """
    words, raw, quote = split(line)
    start = (
        0 if quote else max((raw.rfind(each) for each in breaks if each in ":="), default=-1) + 1
    )
    kept = len(split(raw[:start])[0][-1]) if start else 0
    for value, _ in found(words[1:] or [""]):
        if quote:
            yield value[kept:]
        else:
            end = "" if value.endswith(_OPEN_ENDS) else " "
            yield _SPECIAL.sub(r"\\\1", value[kept:]) + end


def split(line: str) -> tuple[list[str], str, str]:
    """(the words of a line, the last one as it was typed, the quote that is still open in it)."""
    words, raw, quote = [""], "", ""
    pieces = re.finditer(r"\\(.)|([\"'])|(\s+)|.", line, re.S)
    for piece in pieces:
        escaped, mark, space = piece.group(1, 2, 3)
        raw += piece[0]
        if space is not None and not quote:
            words.append("")
            raw = ""
        elif mark is not None and mark == quote:
            quote = ""
        elif mark is not None and not quote:
            quote = mark
        elif escaped is not None and quote == "'":
            words[-1] += piece[0]
        else:
            words[-1] += piece[0] if escaped is None else escaped
    return words, raw, quote
