"""Which host a process runs on, by the rules of a hosts file, and what is wrong with the rules."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from launcher.base.errors import LauncherError, UsageError
from launcher.base.model.record import Record
from launcher.base.model.spec import ProcessSpec, RosIdentity
from launcher.base.text import did_you_mean, several
from launcher.hosts.file.hosts_model import LOCAL, Host, HostsFile, Rule
from launcher.hosts.file.pattern import PatternKind, ProcessPattern, Rank, node_name

_MAX_LISTED = 3  # processes in a remark
_Match = tuple[Rule, ProcessPattern]


class Component(Record):
    """A component that is loaded into the process of a container; both are full names."""

    name: str
    container: str
    package: str | None = None


class Candidates(Record):
    """What a launch file would start: `specs`, and `off`, what conditions keep away.

    Of those that come `later`, only what could be known before is known. `is_complete`: nothing
    else can be started.
    """

    specs: tuple[ProcessSpec, ...]
    later: tuple[ProcessSpec, ...] = ()
    off: tuple[ProcessSpec, ...] = ()
    components: tuple[Component, ...] = ()
    is_complete: bool = True


class PlacementFindings(Record):
    """`errors` with the exit code 2; `warnings` and `remarks` are sentences."""

    errors: tuple[LauncherError, ...] = ()
    warnings: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()


class Placement:
    """The rules of a hosts file, applied to processes."""

    def __init__(self, file: HostsFile) -> None:
        self.file = file
        self._rules: list[_Match] = [
            (rule, ProcessPattern.parse(rule.pattern)) for rule in file.rules
        ]

    def host_of(self, spec: ProcessSpec) -> Host | None:
        """The host; None for this machine. UsageError if rules of equal rank disagree."""
        rule = self.rule_of(spec)
        return None if rule is None or rule.host == LOCAL else self.file.hosts[rule.host]

    def rule_of(self, spec: ProcessSpec) -> Rule | None:
        """The rule that places the process; None if none matches. UsageError as `host_of`."""
        narrow = self._deciding(spec)
        if len({rule.host for rule in narrow}) > 1:
            raise _two_hosts(spec, narrow)
        return narrow[0] if narrow else None

    def _deciding(self, spec: ProcessSpec) -> list[Rule]:
        """The rules of the best rank, without those from which others are exceptions."""
        ranked = [(pattern.rank(spec), rule, pattern) for rule, pattern in self._rules]
        best = min((rank for rank, _, _ in ranked if rank is not None), default=None)
        matches = [(rule, pattern) for rank, rule, pattern in ranked if rank is best is not None]
        return [
            rule
            for rule, pattern in matches
            if not any(pattern.is_wider_than(other, spec) for _, other in matches)
        ]

    # ---- mistakes

    def check(self, candidates: Candidates) -> PlacementFindings:
        """What is wrong with the rules, for what a launch file would start."""
        errors = list(self._conflicts((*candidates.specs, *candidates.later)))
        warnings: list[str] = []
        remarks: list[str] = []
        for rule, pattern in self._rules:
            if any(pattern.rank(spec) is not None for spec in candidates.specs):
                continue
            if any(_may_match(pattern, spec) for spec in candidates.later):
                continue
            off = [spec for spec in candidates.off if _may_match(pattern, spec)]
            if off:
                remarks.append(_switched_off(rule, off))
            elif pattern.rank(_ANY_NODE) in (Rank.ALL, Rank.ALL_NODES):
                warnings.append(f"{rule.where}: '{rule.pattern}' matches nothing here")
            elif not candidates.is_complete:
                text = "matches nothing that can be foreseen; functions may start more"
                warnings.append(f"{rule.where}: '{rule.pattern}' {text}")
            else:
                errors.append(_no_match(rule, pattern, candidates))
        warnings += self._unused()
        return PlacementFindings(tuple(errors), tuple(warnings), tuple(remarks))

    def _conflicts(self, specs: Iterable[ProcessSpec]) -> Iterator[LauncherError]:
        """The first process for each set of rules that disagree."""
        reported: set[frozenset[str]] = set()
        for spec in specs:
            rules = self._deciding(spec)
            key = frozenset(rule.pattern for rule in rules)
            if len({rule.host for rule in rules}) > 1 and key not in reported:
                reported.add(key)
                yield _two_hosts(spec, rules)

    def _unused(self) -> Iterator[str]:
        named = {rule.host for rule, _ in self._rules}
        named |= {self.file.discovery.server, self.file.discovery.backup or LOCAL}
        for name, host in self.file.hosts.items():
            if name not in named:
                yield f"{host.where}: no rule of 'place' names the host '{name}'"


_ANY_NODE = ProcessSpec(
    name="n-1", label="n", argv=(), env={}, ros=RosIdentity(node_name="n", namespace="/n")
)


def _error(rule: Rule, message: str, hint: str | None) -> UsageError:
    return UsageError(
        message, hint=hint, where=rule.where, source_line=rule.source_line, column=rule.column
    )


def _two_hosts(spec: ProcessSpec, rules: Sequence[Rule]) -> UsageError:
    first = rules[0]
    other = next(rule for rule in rules if rule.host != first.host)
    line = first.where.rpartition(":")[2]
    exact = node_name(spec) or ""
    name = exact if exact and not exact.endswith("/") else spec.name
    hint = f"an exact name decides: '{name}: {other.host}'"
    if other.pattern in (name, spec.label) or first.pattern in (name, spec.label):
        hint = "remove one of the two"
    return _error(
        other,
        f"two hosts for {spec.name}: '{other.pattern}' places it on {other.host}, "
        f"and '{first.pattern}' in line {line} on {first.host}",
        hint,
    )


# ---- patterns without a match


def _may_match(pattern: ProcessPattern, spec: ProcessSpec) -> bool:
    """Whether it matches a process that was not evaluated as far as a started one."""
    if pattern.rank(spec) is not None:
        return True
    # The number is given when the process is started.
    stem, dash, number = pattern.body.rpartition("-")
    return (
        pattern.kind is PatternKind.WORD and bool(dash) and number.isdigit() and stem == spec.label
    )


def _switched_off(rule: Rule, off: Sequence[ProcessSpec]) -> str:
    found = dict.fromkeys(f"{_shown(spec)} at {spec.place}" for spec in off)
    names = several(found, _MAX_LISTED)
    return f"{rule.where}: '{rule.pattern}' matches only what a condition keeps away: {names}"


def _shown(spec: ProcessSpec) -> str:
    name = node_name(spec) or ""
    return name if name and not name.endswith("/") else spec.label


def _no_match(rule: Rule, pattern: ProcessPattern, candidates: Candidates) -> UsageError:
    for component in candidates.components:
        if pattern.rank(_as_node(component)) is not None:
            message = f"'{rule.pattern}' is a component, which runs where its container does"
            hint = f"place the container: '{component.container}: {rule.host}'"
            return _error(rule, message, hint)
    known = (*candidates.specs, *candidates.later)
    return _error(rule, f"'{rule.pattern}' matches no process", _hint(pattern, known))


def _as_node(component: Component) -> ProcessSpec:
    namespace, _, name = component.name.rpartition("/")
    ros = RosIdentity(package=component.package, node_name=name, namespace=namespace or "/")
    return ProcessSpec(name=name, label=name, argv=(), env={}, ros=ros)


def _hint(pattern: ProcessPattern, specs: Sequence[ProcessSpec]) -> str | None:
    known = _known(pattern.kind, specs)
    if pattern.kind is PatternKind.WORD and f"/{pattern.body}" in _namespaces(specs):
        return f"'/{pattern.body}' is a namespace: write '/{pattern.body}/**'"
    listed = f"known: {', '.join(known[:12])}{' ...' * (len(known) > 12)}" if known else None
    return did_you_mean(pattern.text, known) or listed


def _known(kind: PatternKind, specs: Sequence[ProcessSpec]) -> list[str]:
    """Patterns of this kind that match something."""
    found: list[str] = []
    for spec in specs:
        match kind:
            case PatternKind.PATH:
                found += [name for name in _nodes([spec]) if not name.endswith("/")]
                found += [f"{namespace}/**" for namespace in _namespaces([spec])]
            case PatternKind.PACKAGE:
                found += [f"package:{spec.ros.package}"] if spec.ros and spec.ros.package else []
            case PatternKind.INCLUDE:
                found += [f"include:{_base(s.path)}" for s in spec.scopes if not s.line]
            case PatternKind.GROUP:
                groups = [scope for scope in spec.scopes if scope.line]
                found += [f"group:{scope.namespace}" for scope in groups if scope.namespace]
                found += [f"group:{_base(scope.path)}:{scope.line}" for scope in groups]
            case PatternKind.PROCESS:
                found += [f"process:{spec.label}", f"process:{spec.name}"]
            case PatternKind.WORD:
                names = [name.rpartition("/")[2] for name in _nodes([spec])]
                found += [*filter(None, names), spec.label]
    return list(dict.fromkeys(found))


def _base(path: str) -> str:
    return path.rpartition("/")[2]


def _nodes(specs: Iterable[ProcessSpec]) -> list[str]:
    return [name for spec in specs if (name := node_name(spec)) is not None]


def _namespaces(specs: Iterable[ProcessSpec]) -> list[str]:
    found = (name.rpartition("/")[0] for name in _nodes(specs))
    return [namespace for namespace in found if namespace]
