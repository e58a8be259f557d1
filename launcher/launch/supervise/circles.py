"""Processes that wait for each other, or are restarted with each other."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterator, Mapping, Sequence

from launcher.base.errors import LauncherError, LaunchFileError
from launcher.base.model.spec import ProcessSpec
from launcher.base.model.supervision import StartRule, circle, restarts_with, rule_for, waits_for

_WILDCARDS = set("*?[")
_MAX_SHOWN = 12  # names of a chain


def circles_in(rules: Sequence[StartRule]) -> Iterator[tuple[str, str, str]]:
    """(pattern, key, message) of what is wrong whatever the processes are called.

    A pattern may be an exception from another, and others may match the same process: only names
    that are written out are compared here, and the rest with the processes of the launch file.
    """
    known = _Patterns(rules)
    for key, names_of in (("after", _after), ("restart_with", _restart_with)):
        edges: dict[str, list[str]] = {}
        for rule in rules:
            names = names_of(rule)
            if names is None:
                continue
            if rule.pattern in names:
                yield rule.pattern, key, _itself(rule.pattern, key)
            else:
                edges[rule.pattern] = [one for name in names for one in known.meant_by(name)]
        found = circle(edges)
        if found:
            yield found[0], key, _message(found, key)


def _after(rule: StartRule) -> Sequence[str] | None:
    return None if rule.after is None else rule.after.names


def _restart_with(rule: StartRule) -> Sequence[str] | None:
    return rule.restart_with


class _Patterns:
    """The patterns of the rules; those without wildcards are names."""

    def __init__(self, rules: Sequence[StartRule]) -> None:
        self._all = {rule.pattern for rule in rules}
        self._names = [name for name in self._all if not _WILDCARDS & set(name)]
        self._meant: dict[str, list[str]] = {}

    def meant_by(self, name: str) -> list[str]:
        """The names that it matches, and the same pattern."""
        if name not in self._meant:
            found = [name] if name in self._all else []
            if _WILDCARDS & set(name):
                found += fnmatch.filter(self._names, name)
            self._meant[name] = found
        return self._meant[name]


def circle_among(rules: Sequence[StartRule], specs: Sequence[ProcessSpec]) -> LauncherError | None:
    """The error for the first circle among the processes of a launch file."""
    own = {spec.name: rule_for(rules, spec) for spec in specs}
    for key, others in (("after", waits_for), ("restart_with", restarts_with)):
        edges: Mapping[str, list[str]] = {
            name: others(rule, name, specs) for name, rule in own.items() if not rule.is_empty
        }
        found = circle(edges)
        if found:
            rule = own[found[0]]
            hint = "processes that wait for each other would never start"
            return LaunchFileError(
                _message(found, key), hint=hint, where=rule.after_where or rule.where
            )
    return None


def _itself(name: str, key: str) -> str:
    return f"'{name}' {_VERBS[key]} itself"


def _message(names: Sequence[str], key: str) -> str:
    """`circle: a waits for b, which waits for a`."""
    shown = names if len(names) <= _MAX_SHOWN else [*names[: _MAX_SHOWN - 1], "...", names[-1]]
    first, *others = shown
    verb = _VERBS[key]
    return f"circle: {first} {verb} " + f", which {verb} ".join(others)


_VERBS = {"after": "waits for", "restart_with": "is restarted with"}
