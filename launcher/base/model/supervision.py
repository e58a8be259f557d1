"""When processes are ready, and which of them wait for others: the data of a supervision file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from launcher.base.model.record import Record, replace
from launcher.base.model.ros_arguments import full_node_name
from launcher.base.model.run_options import RunOptions, matches
from launcher.base.model.spec import ProcessSpec

WAIT_S = 60.0  # how long a process waits for others, where the file does not say
ON_TIMEOUT = ("start", "fail", "stop-run")
EVERY_S = 1.0  # from one attempt of a command or of a connection to the next


class Fact(Record):
    """One fact of `ready_when`.

    `kind` is its key in the file, `subject` the name of a node, topic or service, a lifecycle
    state, a regular expression, `ADDRESS:PORT`, the text of a command, or an exit code. `node` is
    a pattern for the node that has it; empty: that of the process, or any if its name is unknown.
    `request` are the fields of the request to a service, which is only looked for without `call`.
    `words` is a command that no shell splits. `is_own`: only what has come since the start of the
    process counts, and not what its last life has left in the graph.
    """

    kind: str
    subject: str
    node: str = ""
    type: str | None = None
    request: Mapping[str, object] | None = None
    call: bool = True
    words: tuple[str, ...] = ()
    every_s: float = EVERY_S
    is_own: bool = False

    @property
    def text(self) -> str:
        """As in a plan: `publisher on /fleet/tasks`."""
        form = _TEXTS[self.kind]
        of = f" of {self.node}" if self.node and self.kind in _OF_NODE else ""
        return form.format(self.subject) + of


_TEXTS = {
    "node": "node {}",
    "publisher": "publisher on {}",
    "subscription": "subscription on {}",
    "message": "message on {}",
    "service": "answer of service {}",
    "lifecycle": "lifecycle state {}",
    "log": "line with '{}'",
    "port": "TCP port {}",
    "command": "exit code 0 of `{}`",
    "exit": "its exit with code {}",
}
_OF_NODE = ("publisher", "subscription", "message", "lifecycle")
GRAPH_KINDS = ("node", "publisher", "subscription", "message", "service", "lifecycle")


class After(Record):
    """The processes that a process waits for, by patterns, and what happens after `timeout_s`."""

    names: tuple[str, ...]
    timeout_s: float = WAIT_S
    on_timeout: str = ON_TIMEOUT[0]


class StartRule(Record):
    """What a file says about the start of processes that `pattern` matches; None: nothing.

    `where` is its place in the file, `after_where` that of what it waits for.
    """

    pattern: str
    ready_when: tuple[Fact, ...] | None = None
    after: After | None = None
    restart_with: tuple[str, ...] | None = None
    where: str = ""
    after_where: str = ""

    @property
    def is_empty(self) -> bool:
        return not (self.ready_when or self.restart_with or (self.after and self.after.names))


def rule_for(rules: Iterable[StartRule], spec: ProcessSpec) -> StartRule:
    """The rules of one process as one: of each entry, the last that matches counts."""
    found = StartRule(pattern=spec.name)
    for rule in rules:
        if matches(rule.pattern, spec):
            given = {
                name: getattr(rule, name)
                for name in ("ready_when", "after", "restart_with")
                if getattr(rule, name) is not None
            }
            place = rule.after_where if rule.after is not None else found.after_where
            found = replace(found, **given, where=rule.where, after_where=place)
    facts = tuple(_of_process(fact, spec) for fact in found.ready_when or ())
    return replace(found, ready_when=facts)


def setting_changes(old: RunOptions, new: RunOptions, spec: ProcessSpec) -> list[str]:
    """What differs for a process between the supervision files, besides what is in its spec."""
    before, after = (rule_for(one.start_rules, spec) for one in (old, new))
    names = ("ready_when", "after", "restart_with")
    changed = [name for name in names if getattr(before, name) != getattr(after, name)]
    budgets = [
        [one for one in options.file_budgets if matches(one.pattern, spec)]
        for options in (old, new)
    ]
    return changed + ["budget"] * (budgets[0] != budgets[1])


def _of_process(fact: Fact, spec: ProcessSpec) -> Fact:
    """The fact with the names of the process in place of `{name}`, `{node}` and `{namespace}`."""
    node = node_of(spec)
    names = {
        "{name}": spec.label,
        "{node}": node or f"/{spec.label}",
        "{namespace}": (node or "").rpartition("/")[0],
    }

    def filled(text: str) -> str:
        for mark, name in names.items():
            text = text.replace(mark, name)
        return text

    own = node or ("" if fact.kind != "lifecycle" else f"/{spec.label}")
    needs_node = fact.kind in _OF_NODE and not fact.node
    subject = filled(fact.subject)
    return replace(
        fact,
        subject=subject,
        node=own if needs_node else filled(fact.node),
        words=tuple(map(filled, fact.words)),
        is_own=(needs_node and bool(node)) or (fact.kind == "node" and subject == node),
    )


def node_of(spec: ProcessSpec) -> str | None:
    """The full name of its node, as far as its command line says."""
    ros = spec.ros
    if ros is not None and ros.node_name is not None:
        return f"{(ros.namespace or '').rstrip('/')}/{ros.node_name}"
    return full_node_name(spec.argv) if "--ros-args" in spec.argv else None


def waits_for(rule: StartRule, own: str, specs: Iterable[ProcessSpec]) -> list[str]:
    """The names of the processes among `specs` that a process named `own` waits for."""
    names = () if rule.after is None else rule.after.names
    return _named(names, own, specs)


def restarts_with(rule: StartRule, own: str, specs: Iterable[ProcessSpec]) -> list[str]:
    return _named(rule.restart_with or (), own, specs)


def _named(names: Sequence[str], own: str, specs: Iterable[ProcessSpec]) -> list[str]:
    return [s.name for s in specs if s.name != own and any(matches(name, s) for name in names)]


def circle(edges: Mapping[str, Iterable[str]]) -> list[str]:
    """The first circle, as `[a, b, a]`; empty if there is none."""
    done: set[str] = set()
    for start in edges:
        found = _circle_from(start, edges, done)
        if found:
            return found
    return []


def _circle_from(start: str, edges: Mapping[str, Iterable[str]], done: set[str]) -> list[str]:
    """By a stack of our own: a chain may be longer than Python's."""
    path: dict[str, int] = {}
    waiting: list[tuple[str, bool]] = [(start, False)]
    while waiting:
        name, is_leaving = waiting.pop()
        if is_leaving:
            del path[name]
            done.add(name)
        elif name in path:
            return [*list(path)[path[name] :], name]
        elif name not in done:
            path[name] = len(path)
            waiting.append((name, True))
            waiting += [(other, False) for other in edges.get(name, ())]
    return []
