"""Reads a supervision file; all mistakes are reported at once, with their lines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from launcher.base.document.document_reader import DocumentReader, TextLoader, text_of, together
from launcher.base.model.fault_action import FaultAction
from launcher.base.model.supervision import StartRule
from launcher.launch.supervise import fault_fields
from launcher.launch.supervise.circles import circles_in
from launcher.launch.supervise.supervise_fields import FIELDS, SETTINGS, START_FIELDS
from launcher.run.monitor.budget_parser import EXAMPLES, KEYS, budget_of

_EXAMPLE = "as in 'robot_*: {memory: 200M, after: dispatcher}'"
_START = frozenset(field.name for field in START_FIELDS)
Setting = tuple[str, Any]  # a field of RunOptions, and one of its values


def read(path: str) -> list[Setting]:
    """The settings in a file, in order; LauncherError (exit code 2) with all its mistakes."""
    return parse(text_of(path, "the supervision file"), path)


def parse(text: str, path: str) -> list[Setting]:
    """As `read`, of a text; `path` is for places."""
    return _SuperviseReader(text, path).settings()


class _SuperviseReader(DocumentReader):
    def __init__(self, text: str, path: str) -> None:
        super().__init__(text, path, what="a supervision file", hint=_EXAMPLE, loader=TextLoader)

    def settings(self) -> list[Setting]:
        document = self.document() or {}
        found = [
            one
            for name, entry in document.items()
            for one in (
                self._on(entry) if name == fault_fields.ON else self._of_process(name, entry)
            )
        ]
        rules = [value for field, value in found if field == "start_rules"]
        for pattern, key, text in circles_in(rules):
            self.wrong((pattern, key), text, "processes that wait for each other would never start")
        if self.errors:
            raise together(self.errors)
        return found

    def _of_process(self, name: object, entry: object) -> Iterator[Setting]:
        if not isinstance(name, str) or not name.strip():
            self.wrong((name,), "expected the name of a process, or a pattern", _EXAMPLE)
            return
        if not isinstance(entry, Mapping):
            self.wrong((name,), f"'{name}' must be a mapping of settings", _EXAMPLE)
            return
        values = self.fields(entry, FIELDS, (name,), f"'{name}'")
        yield "file_names", (name, str(self.source.origin((name,))))
        yield from self._settings(name, values)
        yield from self._budget(name, entry, values)
        yield from self._start_rule(name, values)

    def _on(self, value: object) -> Iterator[Setting]:
        """Actions for faults: one, or a list."""
        key, example = fault_fields.ON, fault_fields.EXAMPLE
        for index, entry in enumerate(value if isinstance(value, list) else [value]):
            path = (key, index) if isinstance(value, list) else (key,)
            if not isinstance(entry, Mapping):
                hint = f"{example}; a process with this name is '[o]n'"
                self.wrong(path, f"'{key}' must be a list of what is done for faults", hint)
                continue
            values = self.fields(entry, fault_fields.FIELDS, path, f"'{key}'")
            if "headers" in values and values.get("do", {}).get("kind", "webhook") != "webhook":
                self.wrong((*path, "headers"), "only a webhook has headers")
            if "do" not in values or "fault" not in values:
                continue
            where = str(self.source.origin((*path, "do")))
            yield "fault_actions", _fault_action(values, where)
            for name in values["do"].get("names", ()):
                yield "file_names", (name, where)

    def _settings(self, name: str, values: Mapping[str, Any]) -> Iterator[Setting]:
        for key, (field, *_) in SETTINGS.items():
            if key in values:
                yield field, (name, values[key])

    def _budget(
        self, name: str, entry: Mapping[object, object], values: Mapping[str, Any]
    ) -> Iterator[Setting]:
        given = {key: values[key] for key in KEYS if key in values}
        budget = budget_of(name, given)
        if budget is not None:
            yield "file_budgets", budget
        elif given and all(key in values for key in entry):
            self.wrong((name, next(iter(given))), f"no limit for '{name}'", f"as in {EXAMPLES}")

    def _start_rule(self, name: str, values: Mapping[str, Any]) -> Iterator[Setting]:
        given = {key: values[key] for key in _START if key in values}
        if not given:
            return
        place = (name, "after") if "after" in given else (name,)
        rule = StartRule(
            pattern=name,
            **given,
            where=str(self.source.origin((name,))),
            after_where=str(self.source.origin(place)),
        )
        yield "start_rules", rule
        others = [*(rule.after.names if rule.after else ()), *(rule.restart_with or ())]
        for other in others:
            yield "file_names", (other, rule.after_where if rule.after else rule.where)


def _fault_action(values: Mapping[str, Any], where: str) -> FaultAction:
    fields = {"pattern": values["fault"], **values["do"], "where": where}
    if "at_most" in values:
        fields["times"], fields["period_s"] = values["at_most"]
    fields |= {name: values[name] for name in ("when", "headers") if name in values}
    if "within" in values:
        fields["within_s"] = values["within"]
    return FaultAction(**fields)
