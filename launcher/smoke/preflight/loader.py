"""Read an expectation file; all mistakes are reported at once, with their lines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import yaml

from launcher.base.document.document_reader import DocumentReader, meant_names, text_of, together
from launcher.base.document.fields import near
from launcher.base.document.source_location import KeyPath, Origin
from launcher.base.errors import LauncherError, UsageError
from launcher.base.text import suggest
from launcher.smoke.expect.expectation import ALWAYS, START, Expectation
from launcher.smoke.expect.expectation_entries import STEP_FIELDS, TOP_FIELDS
from launcher.smoke.expect.expectation_kinds import BY_NAME, KINDS, ExpectationKind
from launcher.smoke.expect.likeness import Likeness
from launcher.smoke.expect.script import Script
from launcher.smoke.expect.steps import Step, StepCommand
from launcher.smoke.preflight import script_checks

SUFFIXES = (".expect.yaml", ".expect.yml")


def beside(launch_file: str) -> Path | None:
    """The expectation file next to a launch file: `system.expect.yaml` for `system.*`."""
    return next(filter(Path.is_file, _names(launch_file)), None)


def usual(launch_file: str) -> Path:
    """Where one would write it."""
    return next(_names(launch_file))


def _names(launch_file: str) -> Iterator[Path]:
    path = Path(launch_file)
    for end in (".launch.", "_launch.", "-launch.", "."):
        stem, found, _ = path.name.partition(end)
        if found:
            yield from (path.with_name(f"{stem}{suffix}") for suffix in SUFFIXES)


def load(path: str) -> Script:
    """LauncherError with all mistakes of the file."""
    return parse(text_of(path, "the expectations"), path)


def parse_entry(entry: Mapping[str, object], origin: str) -> Expectation:
    """The expectation of a command-line option, which errors name as `origin`."""
    reader = _ExpectationsReader(yaml.safe_dump({"expect": [entry]}), origin)
    try:
        (expectation,) = reader.script().expectations
    except LauncherError as error:
        raise UsageError(f"{origin}: {error.message}", hint=error.hint) from None
    return replace(expectation, origin=Origin(text=origin))


def parse(text: str, path: str) -> Script:
    """LauncherError with all mistakes of the text; `path` is for their places."""
    return _ExpectationsReader(text, path).script()


class _ExpectationsReader(DocumentReader):
    def __init__(self, text: str, path: str) -> None:
        super().__init__(text, path, what="an expectation file", hint="it begins with 'expect:'")

    def script(self) -> Script:
        document = self.document()
        script = Script(path=self.path) if document is None else self._script(document)
        if self.errors:
            # What could be read is checked as well, to report all mistakes at once.
            raise together([*self.errors, *script_checks.of_script(script).errors])
        return script

    # ---- the parts

    def _script(self, document: Mapping[object, object]) -> Script:
        values = self.fields(document, TOP_FIELDS, (), "an expectation file")
        chaos = values.get("chaos")
        script = Script(
            path=self.path,
            for_s=values.get("for"),
            ready_within_s=values.get("ready_within"),
            arguments=values.get("arguments", {}),
            options=values.get("options", ()),
            chaos=None if chaos is None else replace(chaos, seed=values.get("seed", 0)),
            steps=tuple(self._steps(document.get("scenario"))),
            expectations=tuple(self._expectations(document.get("expect"))),
        )
        self._check_names(script)
        return script

    def _entries(
        self, value: object, key: str, noun: str, example: str
    ) -> Iterator[tuple[tuple[str, int], Mapping[object, object]]]:
        """(path, entry) of the mappings in a list."""
        if value is not None and not isinstance(value, list):
            self.wrong((key,), f"'{key}' must be a list", f"as in '- {example}'")
            return
        for index, entry in enumerate(value or ()):
            if isinstance(entry, Mapping) and entry:
                yield (key, index), entry
            else:
                shown = f"{entry}: ..." if str(entry) in BY_NAME else example
                self.wrong((key, index), f"{noun} must be a mapping", f"as in '- {shown}'")

    def _steps(self, value: object) -> Iterator[Step]:
        example = "{at: 8 s, do: kill robot_2}"
        for path, entry in self._entries(value, "scenario", "a step", example):
            values = self.fields(entry, STEP_FIELDS, path, "a step")
            if "do" in values or self.errors:
                command = values.get("do", StepCommand(verb="", text=f"step {path[1] + 1}"))
                yield Step(
                    name=values.get("name", command.text),
                    command=command,
                    delay_s=values.get("at", 0.0),
                    after=values.get("after", START),
                    after_log=values.get("after_log"),
                    process=values.get("process"),
                    origin=self.source.origin(path),
                )

    def _expectations(self, value: object) -> Iterator[Expectation]:
        for path, entry in self._entries(value, "expect", "an expectation", "node: /robot_1"):
            kind = self._kind(entry, path)
            if kind is not None:
                yield from self._expectation(kind, entry, path)

    def _kind(self, entry: Mapping[object, object], path: KeyPath) -> ExpectationKind | None:
        """The kind by its key; `process` may also be an entry of another kind."""
        known = [BY_NAME[str(name)] for name in entry if str(name) in BY_NAME]
        entries = {field.name for kind in known for field in kind.fields}
        own = [kind for kind in known if kind.name not in entries]
        misspelt = misspelt_kind([str(name) for name in entry], own)
        if len(own) == 1 and misspelt is None:
            return own[0]
        if len(own) > 1:
            names = " and ".join(f"'{kind.name}'" for kind in own)
            self.wrong(path, f"{names} are two expectations", "write them as two entries")
            return None
        key = misspelt or next((str(name) for name in entry if str(name) not in ENTRIES), None)
        if key is None:
            kinds = f"one of {', '.join(BY_NAME)}"
            self.wrong(path, "an expectation without its kind", f"it needs {kinds}")
            return None
        self.wrong((*path, key), f"unknown kind of expectation '{key}'", near(key, BY_NAME))
        return None

    def _expectation(
        self, kind: ExpectationKind, entry: Mapping[object, object], path: KeyPath
    ) -> Iterator[Expectation]:
        before = len(self.errors)
        subject = self.parsed(kind.subject, entry[kind.name], (*path, kind.name))
        if isinstance(subject, Likeness):
            subject = subject.beside(self.path)
        rest = {name: value for name, value in entry.items() if name != kind.name}
        values = self.fields(rest, kind.all_fields(), path, f"'{kind.name}'")
        meant = meant_names(rest, [field.name for field in kind.all_fields()])
        if kind.one_of and not any(name in entry or name in meant for name in kind.one_of):
            names = ", ".join(f"'{name}'" for name in kind.one_of)
            self.wrong(path, f"'{kind.name}' needs one of {names}")
        answer = [name for name in ("request", "once", "where", "fields") if name in values]
        if values.get("call") is False and answer:
            self.wrong((*path, answer[0]), f"'{answer[0]}' needs a call, and 'call' is false")
        if len(self.errors) > before:
            return
        yield Expectation(
            kind=kind.name,
            subject=subject,
            name=values.pop("name", ""),
            # What must never appear has no time limit by default.
            within=values.pop("within", None if values.get("absent") else kind.default_within),
            after=values.pop("after", START),
            values=values,
            origin=self.source.origin(path),
        )

    def _check_names(self, script: Script) -> None:
        counts = Counter([*ALWAYS, *script.moments()])
        earlier = dict.fromkeys(ALWAYS)
        for step in script.steps:
            if counts[step.name] > 1:
                self.errors.append(
                    step.origin.error(f"duplicate step name '{step.name}'", "give one a 'name'")
                )
            self._check_name(step.after, earlier, step.origin)
            earlier |= dict.fromkeys(step.moments)
        for expectation in script.expectations:
            self._check_name(expectation.after, counts, expectation.origin)

    def _check_name(self, name: str, known: Mapping[str, object], origin: Origin) -> None:
        if name not in known:
            text = f"unknown step '{name}'"
            self.errors.append(origin.error(text, near(name, known), "after"))


# The entries of all kinds.
ENTRIES = frozenset(field.name for kind in KINDS for field in kind.all_fields())


def misspelt_kind(names: Sequence[str], own: Sequence[ExpectationKind]) -> str | None:
    """The name among those of an entry that is a misspelt kind, as `parametr`.

    `own`: kinds that the other names are. `node` beside `parametr` is an entry of it.
    """
    for name in names:
        if name in ENTRIES or name in BY_NAME:
            continue
        meant = suggest(name, BY_NAME)
        if meant is not None and {kind.name for kind in own} <= _entries(BY_NAME[meant]):
            return name
    return None


def _entries(kind: ExpectationKind) -> set[str]:
    return {field.name for field in kind.all_fields()}
