"""Completion of verbs, names and patterns of processes, options, signals and levels."""

from __future__ import annotations

import fnmatch
import re
import shlex
import signal
from collections import Counter
from collections.abc import AsyncGenerator, Awaitable, Callable, Iterable, Mapping, Sequence
from typing import Any

from prompt_toolkit.completion import CompleteEvent, Completer, Completion
from prompt_toolkit.document import Document

from launcher.base.program import without_program
from launcher.base.run_verb import Verb
from launcher.control.console.bar import short_names
from launcher.control.console.requests import CLEAR, CLEAR_HELP, SHELL_HELP, SHELL_VERBS, runs_here
from launcher.control.verbs import EVERYTHING, VERBS, find
from launcher.output.filters import LEVELS

# Words for the first argument of a verb, by its name.
WORDS = {"level": (*LEVELS, "ALL"), "format": ("compact", "default"), "topic": (EVERYTHING,)}
_GLOB = re.compile(r"[*?\[]")
_NUMBER_AT_END = re.compile(r"\d+$")

_OPEN_ENDS = ("=", "/")  # more of the word follows

Processes = Callable[[], Sequence[Mapping[str, Any]]]
Ask = Callable[[Sequence[str]], Awaitable[Sequence[tuple[str, str]]]]


class WordCompleter(Completer):
    """Completes the word at the cursor; `processes()` returns rows of `ps`.

    `ask` returns candidates, each with a text about it, for the last of the words of a verb of
    shells.
    """

    def __init__(self, processes: Processes, ask: Ask) -> None:
        self._processes = processes
        self._ask = ask

    async def get_completions_async(
        self, document: Document, complete_event: CompleteEvent
    ) -> AsyncGenerator[Completion, None]:
        """Those of a verb of shells are computed by a separate process, as shells do."""
        before, word = _words(document)
        if before and runs_here(before[0]):
            for candidate, meta in await self._ask([*before, word]):
                end = "" if candidate.endswith(_OPEN_ENDS) else " "
                text = shlex.quote(candidate) + end
                yield Completion(text, -len(word), display=candidate, display_meta=meta)
            return
        for completion in self.get_completions(document, complete_event):
            yield completion

    def get_completions(
        self, document: Document, complete_event: CompleteEvent
    ) -> Iterable[Completion]:
        before, word = _words(document)
        if _GLOB.search(word) and before:
            yield from self._expanded(word)
            return
        for candidate, meta in self._candidates(before, word):
            if candidate.startswith(word) and candidate not in before[1:]:
                yield Completion(candidate + " ", -len(word), display=candidate, display_meta=meta)

    def _candidates(self, before: Sequence[str], word: str) -> Iterable[tuple[str, str]]:
        if not before:
            own = [*((verb.name, verb.help) for verb in VERBS), (CLEAR, CLEAR_HELP)]
            return [
                *own,
                *((name, SHELL_HELP) for name in dict.fromkeys(SHELL_VERBS) if runs_here(name)),
            ]
        verb = find(before[0])
        if verb is None:
            return []
        option = next((one for one in verb.options if before[-1] in one.flags), None)
        if option is not None and option.kind == "signal":
            return [(one.name, "") for one in signal.Signals]
        if option is not None and option.kind != "flag":
            return []
        if word.startswith("-"):
            return [(flag, one.help) for one in verb.options for flag in one.flags]
        if verb.argument is not None and len(before) == 1:
            return [(word, "") for word in WORDS.get(verb.argument, ())]
        if verb.behind and len(before) > 1:
            return [(word, "") for word in WORDS.get(verb.behind[-1].name, ()) if word != "ALL"]
        if verb.rest is not None and len(before) == 2:
            return [(word, "") for word in verb.rest.choices]
        return [] if self._has_names(verb, before) else self._names()

    @staticmethod
    def _has_names(verb: Verb, before: Sequence[str]) -> bool:
        return verb.names == "none" or (verb.names in ("one", "perhaps") and len(before) > 1)

    def _names(self) -> list[tuple[str, str]]:
        found = self._processes()
        names, globs = names_of(found), globs_of(found)
        # Tab inserts the first one: never several processes where one is meant.
        return [(word, "") for word in (*sorted(names), *sorted(globs - names))]

    def _expanded(self, word: str) -> Iterable[Completion]:
        names = [p["name"] for p in self._processes() if fnmatch.fnmatchcase(p["name"], word)]
        labels = [p["name"] for p in self._processes() if fnmatch.fnmatchcase(_label(p), word)]
        meant = names or labels
        if meant:
            yield Completion(" ".join(meant), -len(word), display=f"{word}: {len(meant)}")


def _words(document: Document) -> tuple[list[str], str]:
    """Those in front of the word at the cursor, without the program's name; that word."""
    *before, word = re.split(r"\s+", document.text_before_cursor.lstrip())
    return without_program(before), word


def _label(process: Mapping[str, Any]) -> str:
    return str(process.get("label") or process["name"])


def names_of(processes: Sequence[Mapping[str, Any]]) -> set[str]:
    """Words that select one process: labels if they are unique, else names; nodes."""
    words = set(short_names(processes).values())
    for process in processes:
        words.update(process.get("node_names") or ())
    return words


def globs_of(processes: Sequence[Mapping[str, Any]]) -> set[str]:
    """Words that select several: `robot_*` for robot_1 and robot_2, and namespaces."""
    stems = Counter(
        _NUMBER_AT_END.sub("", label)
        for label in {_label(p) for p in processes}
        if _NUMBER_AT_END.search(label)
    )
    spaces = {str(p["namespace"]) for p in processes if p.get("namespace") not in (None, "", "/")}
    return {f"{stem}*" for stem, count in stems.items() if stem and count > 1} | spaces
