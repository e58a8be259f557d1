"""Which host a process runs on, by the rules of a hosts file."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.errors import UsageError
from launcher.hosts.model import LOCAL, Host, HostsFile, Rule
from launcher.hosts.pattern import Pattern
from launcher.model.spec import ProcessSpec

_Match = tuple[Rule, Pattern]


class Placement:
    """The rules of a hosts file, applied to processes."""

    def __init__(self, file: HostsFile) -> None:
        self.file = file
        self._rules: list[_Match] = [(rule, Pattern.parse(rule.pattern)) for rule in file.rules]

    def host_of(self, spec: ProcessSpec) -> Host | None:
        """The host; None for this machine. UsageError if rules of equal rank disagree."""
        rule = self.rule_of(spec)
        return None if rule is None or rule.host == LOCAL else self.file.hosts[rule.host]

    def rule_of(self, spec: ProcessSpec) -> Rule | None:
        """The rule that places the process; None if none matches. UsageError as `host_of`."""
        ranked = [(pattern.rank(spec), rule, pattern) for rule, pattern in self._rules]
        best = min((rank for rank, _, _ in ranked if rank is not None), default=None)
        matches = [(rule, pattern) for rank, rule, pattern in ranked if rank is best is not None]
        narrow = [
            (rule, pattern)
            for rule, pattern in matches
            if not any(pattern.is_wider_than(other, spec) for _, other in matches)
        ]
        if len({rule.host for rule, _ in narrow}) > 1:
            raise _two_hosts(spec, [rule for rule, _ in narrow])
        return narrow[0][0] if narrow else None


def _two_hosts(spec: ProcessSpec, rules: Sequence[Rule]) -> UsageError:
    first = rules[0]
    other = next(rule for rule in rules if rule.host != first.host)
    line = first.where.rpartition(":")[2]
    return UsageError(
        f"process '{spec.name}' has two hosts: '{other.pattern}' places it on {other.host}, "
        f"and '{first.pattern}' in line {line} on {first.host}",
        hint=f"an exact name decides: '{spec.label}: {other.host}'",
        where=other.where,
        source_line=other.source_line,
        column=other.column,
    )
