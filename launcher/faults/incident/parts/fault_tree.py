"""The faults of an incident: the root, and below each those that follow from it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from launcher.base import strict_json
from launcher.base.text import count
from launcher.faults.incident import markup
from launcher.faults.incident.document import IncidentDocument, ReportedFault
from launcher.faults.incident.limits import PageLimits, clipped
from launcher.faults.incident.markup import EMPTY, Markup, details, facts, join, section, tag
from launcher.faults.incident.parts.span import clock, length, offset

MAX_FAULTS = 100
MAX_LINES = 60
MAX_CHARACTERS = 8000  # of a message, or of the lines of a fault
_MAX_DEPTH = 8
_STATES = {"active": "bad", "healed": "good", "suspected": "warn"}


class _FaultTree:
    """The faults that are shown, each once."""

    def __init__(self, faults: Sequence[ReportedFault], zero_s: float, limits: PageLimits) -> None:
        self.faults = faults
        self.zero_s = zero_s
        self.limits = limits
        self.left = limits.of(MAX_FAULTS)

    def markup(self) -> Markup:
        shown = [self._branch(one, frozenset(), 0) for one in roots_of(self.faults)]
        return tag("ul", *shown, class_="faults") if shown else EMPTY

    def _branch(self, fault: ReportedFault, above: frozenset[str], depth: int) -> Markup:
        if self.left <= 0:
            return EMPTY
        self.left -= 1
        seen = above | {fault.fault}
        followers = [one for one in self.faults if one.follows == fault.fault]
        below = [
            self._branch(one, seen, depth + 1)
            for one in followers
            if one.fault not in seen and depth < _MAX_DEPTH
        ]
        card = _card(fault, self.zero_s, self.limits, is_root=depth == 0)
        return tag("li", card, tag("ul", *below, class_="faults") if any(below) else EMPTY)


def faults(incident: IncidentDocument, limits: PageLimits) -> Markup:
    title = count(len(incident.faults), "fault").capitalize()
    tree = _FaultTree(incident.faults, incident.opened_s, limits)
    shown = tree.markup()
    more = len(incident.faults) - limits.of(MAX_FAULTS)
    note = tag("p", f"{more} more faults are in the document.") if more > 0 else EMPTY
    return section("faults", title, shown, note)


def roots_of(found: Sequence[ReportedFault]) -> list[ReportedFault]:
    """Those that follow from none of the incident; of a circle, its first."""
    names = {one.fault for one in found}
    roots = [one for one in found if one.follows not in names or one.follows == one.fault]
    reached = {name for root in roots for name in _below(root.fault, found)}
    for one in found:
        if one.fault not in reached:
            roots.append(one)
            reached |= _below(one.fault, found)
    return roots


def _below(name: str, found: Sequence[ReportedFault]) -> set[str]:
    reached = {name}
    waiting = [name]
    while waiting:
        above = waiting.pop()
        new = {one.fault for one in found if one.follows == above} - reached
        reached |= new
        waiting += new
    return reached


def _card(fault: ReportedFault, zero_s: float, limits: PageLimits, *, is_root: bool) -> Markup:
    kind = _STATES.get(fault.state, "plain")
    badges = [tag("span", fault.state or "state unknown", class_=f"badge {kind}")]
    badges += [tag("span", one, class_="badge plain") for one in fault.notes]
    head = tag("h3", fault.fault)
    rows = tag(
        "dl",
        *_pair("expected", fault.expected),
        *_pair("seen", fault.seen),
        class_="compare",
    )
    cause = tag("p", tag("strong", "Cause: "), fault.cause) if fault.cause else EMPTY
    lead = tag("p", f"follows from {fault.follows}", class_="muted small") if not is_root else EMPTY
    body = [tag("div", head, *badges, class_="fault-head"), lead, rows, cause]
    body += [facts(_rows(fault, zero_s), "facts small"), *_evidence(fault, limits)]
    return tag("article", *body, class_=f"card fault {'root ' if is_root else ''}{kind}")


def _pair(name: str, value: str) -> list[Markup]:
    return [tag("div", tag("dt", name), tag("dd", value))] if value else []


def _rows(fault: ReportedFault, zero_s: float) -> Iterator[tuple[str, object]]:
    for name, at_s in (
        ("First seen", fault.first_s),
        ("Confirmed", fault.confirmed_s),
        ("Last seen", fault.last_s),
        ("Healed", fault.healed_s),
    ):
        yield name, None if at_s is None else _moment(at_s, zero_s)
    if fault.first_s is not None and fault.healed_s is not None:
        yield "Lasted", length(fault.healed_s - fault.first_s)
    yield "Confirmed in this run", count(fault.count, "time") if fault.count > 1 else None
    yield "Kind", fault.kind
    yield "Rule of the cause", fault.rule
    yield "Expectation", tag("code", fault.place) if fault.place else "implied"
    for name, values in (
        ("Processes", fault.processes),
        ("Topics", fault.topics),
        ("Nodes", fault.nodes),
    ):
        yield name, join((tag("code", one) for one in values), " ") if values else None


def _moment(at_s: float, zero_s: float) -> Markup:
    return join([clock(at_s), " ", tag("span", f"({offset(at_s, zero_s)})", class_="offset")])


def _evidence(fault: ReportedFault, limits: PageLimits) -> Iterator[Markup]:
    if fault.lines:
        own = fault.lines[-MAX_LINES:]
        shown = clipped("\n".join(own), limits.of(MAX_CHARACTERS))
        yield details(f"Last {count(len(own), 'line')}", block(shown))
    if fault.message is not None:
        document = strict_json.dumps(fault.message, indent=1, ensure_ascii=False)
        yield details("Last message", block(clipped(document, limits.of(MAX_CHARACTERS))))


def block(text: str) -> Markup:
    """Text with its line breaks."""
    return tag("pre", markup.text(text, keep="\n\t"), tabindex="0")
