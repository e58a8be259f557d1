"""Read an expectation file; all mistakes are reported at once, with their lines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from launcher.errors import LauncherError, LaunchFileError, SeveralErrors, UsageError
from launcher.smoke.expect.expectation import ALWAYS, START, Expectation
from launcher.smoke.expect.expectation_kinds import BY_NAME, KINDS, Kind
from launcher.smoke.expect.fields import Field, FieldType, near
from launcher.smoke.expect.grammar import STEP_FIELDS, TOP_FIELDS
from launcher.smoke.expect.script import Script
from launcher.smoke.expect.source_location import KeyPath, Origin, SourceMap, entries_of
from launcher.smoke.expect.steps import Command, Step
from launcher.smoke.preflight import checks
from launcher.smoke.preflight.checks import together
from launcher.text import suggest

SUFFIXES = (".expect.yaml", ".expect.yml")
QUOTES = "a string with a brace, a bracket or ': ' in it needs quotes"
# The C library reads a long file twenty times as fast.
_YAML: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def beside(launch_file: str) -> Path | None:
    """The expectation file next to a launch file: `system.expect.yaml` for `system.*`."""
    folder, name = Path(launch_file).parent, Path(launch_file).name
    for end in (".launch.", "_launch.", "-launch.", "."):
        stem, found, _ = name.partition(end)
        paths = [folder / f"{stem}{suffix}" for suffix in SUFFIXES] if found else []
        for path in filter(Path.is_file, paths):
            return path
    return None


def load(path: str) -> Script:
    """LauncherError with all mistakes of the file."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise LaunchFileError(
            f"cannot read the expectations: {error.strerror}", where=path
        ) from None
    except UnicodeDecodeError as error:
        raise LaunchFileError(f"not UTF-8: {error.reason}", where=path) from None
    return parse(text, path)


def parse_entry(entry: Mapping[str, object], origin: str) -> Expectation:
    """The expectation of a command-line option, which errors name as `origin`."""
    reader = _Reader(yaml.safe_dump({"expect": [entry]}, allow_unicode=True), origin)
    try:
        (expectation,) = reader.script().expectations
    except LauncherError as error:
        raise UsageError(f"{origin}: {error.message}", hint=error.hint) from None
    return replace(expectation, origin=Origin(text=origin))


def parse(text: str, path: str) -> Script:
    """LauncherError with all mistakes of the text; `path` is for their places."""
    return _Reader(text, path).script()


class _Reader:
    def __init__(self, text: str, path: str) -> None:
        self._text = text
        self._path = path
        self._source = SourceMap(text, path)
        self._errors: list[LauncherError] = []

    def script(self) -> Script:
        document = self._document()
        script = Script(path=self._path) if document is None else self._script(document)
        if self._errors:
            # What could be read is checked as well, to report all mistakes at once.
            raise together([*self._errors, *checks.of_script(script).errors])
        return script

    def _document(self) -> Mapping[object, object] | None:
        loader = _YAML(self._text)
        try:
            root = loader.get_single_node()
            if root is None:
                return None
            self._refuse_duplicates(root)
            self._source.root = root
            document = loader.construct_document(root)
        except (yaml.YAMLError, ValueError, TypeError) as error:
            raise self._yaml_error(error) from None
        finally:
            loader.dispose()
        if not isinstance(document, Mapping):
            self._wrong((), "an expectation file must be a mapping", "it begins with 'expect:'")
            return None
        return document

    def _yaml_error(self, error: Exception) -> LauncherError:
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        message = getattr(error, "problem", None) or str(error)
        if message.startswith("but "):
            message = f"{getattr(error, 'context', None)}, {message}"
        if mark is None:
            return LaunchFileError(f"invalid YAML: {message}", where=self._path)
        lines = self._source.lines
        line = lines[mark.line] if mark.line < len(lines) else ""
        hint = None
        if "\t" in line[: mark.column + 1]:
            hint = "indent YAML with spaces, not with tabs"
        elif "expected" in message or "not allowed" in message:
            hint = QUOTES
        return self._source.error_at(mark, f"invalid YAML: {message}", hint)

    def _refuse_duplicates(self, root: yaml.Node) -> None:
        """Duplicate keys, of which YAML's reader silently takes the last one."""
        open_nodes: set[int] = set()
        visited: set[int] = set()  # what aliases repeat is visited once

        def visit(node: yaml.Node) -> None:
            if id(node) in open_nodes:
                self._errors.append(self._source.error_at(node.start_mark, "recursive alias"))
                raise SeveralErrors(self._errors)
            if id(node) in visited:
                return
            visited.add(id(node))
            open_nodes.add(id(node))
            keys: set[object] = set()
            for name, key, value in entries_of(node):
                if name in keys and key is not None and name != "<<":
                    message = f"duplicate key '{name}'"
                    self._errors.append(self._source.error_at(key.start_mark, message))
                keys.add(name)
                visit(value)
            open_nodes.discard(id(node))

        visit(root)

    # ---- the parts

    def _script(self, document: Mapping[object, object]) -> Script:
        values = self._fields(document, TOP_FIELDS, (), "an expectation file")
        chaos = values.get("chaos")
        script = Script(
            path=self._path,
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
            self._wrong((key,), f"'{key}' must be a list", f"as in '- {example}'")
            return
        for index, entry in enumerate(value or ()):
            if isinstance(entry, Mapping) and entry:
                yield (key, index), entry
            else:
                shown = f"{entry}: ..." if str(entry) in BY_NAME else example
                self._wrong((key, index), f"{noun} must be a mapping", f"as in '- {shown}'")

    def _steps(self, value: object) -> Iterator[Step]:
        example = "{at: 8 s, do: kill robot_2}"
        for path, entry in self._entries(value, "scenario", "a step", example):
            values = self._fields(entry, STEP_FIELDS, path, "a step")
            if "do" in values or self._errors:
                command = values.get("do", Command(verb="", text=f"step {path[1] + 1}"))
                yield Step(
                    name=values.get("name", command.text),
                    command=command,
                    delay_s=values.get("at", 0.0),
                    after=values.get("after", START),
                    after_log=values.get("after_log"),
                    process=values.get("process"),
                    origin=self._source.origin(path),
                )

    def _expectations(self, value: object) -> Iterator[Expectation]:
        for path, entry in self._entries(value, "expect", "an expectation", "node: /robot_1"):
            kind = self._kind(entry, path)
            if kind is not None:
                yield from self._expectation(kind, entry, path)

    def _kind(self, entry: Mapping[object, object], path: KeyPath) -> Kind | None:
        """The kind by its key; `process` may also be an entry of another kind."""
        known = [BY_NAME[str(name)] for name in entry if str(name) in BY_NAME]
        entries = {field.name for kind in known for field in kind.fields}
        own = [kind for kind in known if kind.name not in entries]
        misspelt = misspelt_kind([str(name) for name in entry], own)
        if len(own) == 1 and misspelt is None:
            return own[0]
        if len(own) > 1:
            names = " and ".join(f"'{kind.name}'" for kind in own)
            self._wrong(path, f"{names} are two expectations", "write them as two entries")
            return None
        key = misspelt or next((str(name) for name in entry if str(name) not in ENTRIES), None)
        if key is None:
            kinds = f"one of {', '.join(BY_NAME)}"
            self._wrong(path, "an expectation without its kind", f"it needs {kinds}")
            return None
        self._wrong((*path, key), f"unknown kind of expectation '{key}'", near(key, BY_NAME))
        return None

    def _expectation(
        self, kind: Kind, entry: Mapping[object, object], path: KeyPath
    ) -> Iterator[Expectation]:
        before = len(self._errors)
        subject = self._parsed(kind.subject, entry[kind.name], (*path, kind.name))
        rest = {name: value for name, value in entry.items() if name != kind.name}
        values = self._fields(rest, kind.all_fields(), path, f"'{kind.name}'")
        meant = _meant(rest, [field.name for field in kind.all_fields()])
        if kind.one_of and not any(name in entry or name in meant for name in kind.one_of):
            names = ", ".join(f"'{name}'" for name in kind.one_of)
            self._wrong(path, f"'{kind.name}' needs one of {names}")
        answer = [name for name in ("request", "once", "where", "fields") if name in values]
        if values.get("call") is False and answer:
            self._wrong((*path, answer[0]), f"'{answer[0]}' needs a call, and 'call' is false")
        if len(self._errors) > before:
            return
        yield Expectation(
            kind=kind.name,
            subject=subject,
            name=values.pop("name", ""),
            # What must never appear has no time limit by default.
            within=values.pop("within", None if values.get("absent") else kind.default_within),
            after=values.pop("after", START),
            values=values,
            origin=self._source.origin(path),
        )

    def _check_names(self, script: Script) -> None:
        counts = Counter([*ALWAYS, *script.moments()])
        earlier = dict.fromkeys(ALWAYS)
        for step in script.steps:
            if counts[step.name] > 1:
                self._errors.append(
                    step.origin.error(f"duplicate step name '{step.name}'", "give one a 'name'")
                )
            self._check_name(step.after, earlier, step.origin)
            earlier |= dict.fromkeys(step.moments)
        for expectation in script.expectations:
            self._check_name(expectation.after, counts, expectation.origin)

    def _check_name(self, name: str, known: Mapping[str, object], origin: Origin) -> None:
        if name not in known:
            text = f"unknown step '{name}'"
            self._errors.append(origin.error(text, near(name, known), "after"))

    # ---- fields

    def _fields(
        self, entry: Mapping[object, object], known: Sequence[Field], path: KeyPath, what: str
    ) -> dict[str, Any]:
        types = {field.name: field.type for field in known}
        values: dict[str, Any] = {}
        for name, value in entry.items():
            if name not in types:
                hint = near(name, types)
                self._wrong((*path, name), f"unknown key '{name}' of {what}", hint)
            else:
                values[str(name)] = self._parsed(types[name], value, (*path, name))
        meant = _meant(entry, types)
        for field in known:
            if field.required and field.name not in entry and field.name not in meant:
                self._wrong(path, f"{what} needs '{field.name}': {field.doc}")
        return {name: value for name, value in values.items() if value is not _BAD}

    def _parsed(self, type_: FieldType, value: object, path: KeyPath) -> Any:
        try:
            return type_.parse(value)
        except ValueError as error:
            for one in getattr(error, "all", (error,)):
                inner: KeyPath = getattr(one, "path", ())
                hint = getattr(one, "hint", None)
                self._wrong((*path, *inner), str(one), hint, value=not getattr(one, "key", False))
            return _BAD

    # ---- places

    def _wrong(
        self, path: KeyPath, message: str, hint: str | None = None, *, value: bool = False
    ) -> None:
        self._errors.append(self._source.error(path, message, hint, value=value))


_BAD = object()
# The entries of all kinds.
ENTRIES = frozenset(field.name for kind in KINDS for field in kind.all_fields())


def misspelt_kind(names: Sequence[str], own: Sequence[Kind]) -> str | None:
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


def _entries(kind: Kind) -> set[str]:
    return {field.name for field in kind.all_fields()}


def _meant(entry: Mapping[object, object], known: Iterable[str]) -> set[str | None]:
    """What the unknown names of an entry are similar to: that is not missing."""
    names = list(known)
    return {suggest(str(name), names) for name in entry if name not in names}
